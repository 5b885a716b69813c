#include "server/api/wire.h"

#include "common/base/check.h"
#include "proto/convert/bounded_parse.h"

namespace shutterline::server {

absl::Status Decode(const grpc::ByteBuffer& bytes, google::protobuf::Message& message) {
  grpc::Slice slice;
  if (!bytes.TrySingleSlice(&slice).ok() && !bytes.DumpToSingleSlice(&slice).ok()) {
    return absl::InvalidArgumentError("malformed message: it is compressed badly");
  }
  return convert::ParseBounded({reinterpret_cast<const char*>(slice.begin()), slice.size()}, kMaxFields,
                               message);
}

grpc::ByteBuffer Encode(const google::protobuf::Message& message) {
  grpc::Slice slice(message.ByteSizeLong());
  SL_CHECK(message.SerializeToArray(const_cast<uint8_t*>(slice.begin()), int(slice.size())));
  return grpc::ByteBuffer(&slice, 1);
}

}  // namespace shutterline::server
