#pragma once

#include <absl/status/status.h>
#include <google/protobuf/message.h>
#include <grpcpp/support/byte_buffer.h>

#include <cstddef>

/// Messages of calls that are served raw: such a call's bytes are counted before they are parsed, and parsed
/// where the number of those who parse is bounded.
namespace shutterline::server {

/// Fields and elements of any honest request: a Submit of 10,000 files has 60,000, a FindMissing of 20,000
/// digests 40,000.
inline constexpr size_t kMaxFields = 200'000;

/// INVALID_ARGUMENT as convert::ParseBounded.
absl::Status Decode(const grpc::ByteBuffer& bytes, google::protobuf::Message& message);
grpc::ByteBuffer Encode(const google::protobuf::Message& message);

}  // namespace shutterline::server
