#include "server/api/asset_service.h"

#include <absl/container/flat_hash_set.h>
#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"
#include "server/api/blob_reactors.h"
#include "server/api/limits.h"
#include "server/api/unary.h"
#include "server/api/wire.h"

namespace shutterline::server {

absl::Status AssetService::DoFindMissing(const v1::DigestList& request, v1::DigestList& response) {
  if (uint32_t(request.digests_size()) > kMaxDigests) {
    return absl::InvalidArgumentError(absl::StrCat("digests: has ", request.digests_size(),
                                                   " entries, but at most ", kMaxDigests, " may be"));
  }
  absl::flat_hash_set<Digest> seen;
  for (int i = 0; i < request.digests_size(); ++i) {
    SL_ASSIGN_OR_RETURN(const Digest digest,
                        convert::FromProto(request.digests(i), absl::StrCat("digests[", i, "]")));
    if (!seen.insert(digest).second) continue;
    const absl::StatusOr<uint64_t> size = store_.Size(digest);
    if (absl::IsNotFound(size.status())) {
      *response.add_digests() = request.digests(i);
    } else {
      SL_RETURN_IF_ERROR(size.status());
    }
  }
  return absl::OkStatus();
}

grpc::ServerUnaryReactor* AssetService::FindMissing(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request,
                                                    grpc::ByteBuffer* response) {
  return AnswerFrom(pool_, context, [this, request, response]() -> absl::Status {
    v1::DigestList digests, missing;
    SL_RETURN_IF_ERROR(Decode(*request, digests));
    SL_RETURN_IF_ERROR(DoFindMissing(digests, missing));
    *response = Encode(missing);
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* AssetService::QueryWrite(grpc::CallbackServerContext* context,
                                                   const v1::Digest* request, v1::Committed* response) {
  return AnswerFrom(pool_, context, [this, request, response]() -> absl::Status {
    SL_ASSIGN_OR_RETURN(const Digest digest, convert::FromProto(*request, ""));
    SL_ASSIGN_OR_RETURN(const CommittedBlob blob, store_.Query(digest));
    response->set_size_bytes(blob.size);
    response->set_complete(blob.complete);
    return absl::OkStatus();
  });
}

grpc::ServerReadReactor<v1::BlobChunk>* AssetService::Write(grpc::CallbackServerContext* context,
                                                            v1::Committed* response) {
  return new BlobWriteReactor(store_, pool_, limits_, context, response);  // Frees itself in OnDone.
}

grpc::ServerWriteReactor<v1::BlobChunk>* AssetService::Read(grpc::CallbackServerContext*,
                                                            const v1::ReadRequest* request) {
  return new BlobReadReactor(store_, pool_, limits_, *request);  // Frees itself in OnDone.
}

}  // namespace shutterline::server
