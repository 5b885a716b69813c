#pragma once

#include "server/api/stream_limits.h"
#include "server/assets/asset_store.h"
#include "server/control/work_pool.h"
#include "shutterline/v1/blobs.grpc.pb.h"

namespace shutterline::server {

/// The Blobs service over an AssetStore, which outlives it, as the pool does.
class AssetService final : public v1::Blobs::WithRawCallbackMethod_FindMissing<v1::Blobs::CallbackService> {
 public:
  AssetService(AssetStore& store, WorkPool& pool, StreamLimits& limits)
      : store_(store), pool_(pool), limits_(limits) {}

  grpc::ServerUnaryReactor* FindMissing(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerReadReactor<v1::BlobChunk>* Write(grpc::CallbackServerContext* context,
                                                v1::Committed* response) override;
  grpc::ServerUnaryReactor* QueryWrite(grpc::CallbackServerContext* context, const v1::Digest* request,
                                       v1::Committed* response) override;
  grpc::ServerWriteReactor<v1::BlobChunk>* Read(grpc::CallbackServerContext* context,
                                                const v1::ReadRequest* request) override;

 private:
  absl::Status DoFindMissing(const v1::DigestList& request, v1::DigestList& response);

  AssetStore& store_;
  WorkPool& pool_;
  StreamLimits& limits_;
};

}  // namespace shutterline::server
