#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/server_context.h>

#include <cstdint>
#include <memory>
#include <optional>

#include "common/asset/digest.h"
#include "server/api/download_reactor.h"
#include "server/api/stream_limits.h"
#include "server/assets/asset_store.h"
#include "server/control/work_pool.h"
#include "shutterline/v1/blobs.pb.h"

namespace shutterline::server {

/// One Write call: a chunk is read, then stored on the pool, then the next. A writer that stalls is ended
/// with DEADLINE_EXCEEDED; what came stays for the next one.
class BlobWriteReactor final : public grpc::ServerReadReactor<v1::BlobChunk> {
 public:
  BlobWriteReactor(AssetStore& store, WorkPool& pool, StreamLimits& limits,
                   grpc::CallbackServerContext* context, v1::Committed* response);

  void OnReadDone(bool ok) override;
  void OnDone() override;

 private:
  void ReadNext();
  void Expire();
  absl::Status Begin();
  absl::Status Store();
  absl::Status Complete();
  void End(const absl::Status& status);
  void Close(const absl::Status& status);

  AssetStore& store_;
  WorkPool& pool_;
  StreamLimits& limits_;
  StreamBudget::Slot slot_;
  UploadQuota::Share share_;
  grpc::CallbackServerContext* const context_;
  v1::Committed* const response_;
  v1::BlobChunk chunk_;
  std::unique_ptr<BlobWriter> writer_;  ///< Null before the first chunk, and where the blob is here already.
  bool begun_ = false;
  uint64_t position_ = 0;  ///< Where the next chunk must start.

  absl::Mutex mutex_;
  StreamDeadlines::Id stall_deadline_ ABSL_GUARDED_BY(mutex_) = 0;
  bool reading_ ABSL_GUARDED_BY(mutex_) = false;  ///< The client's turn; all members above rest.
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

/// One Read call: a chunk is read on the pool and written, then the next. A stream from the beginning is
/// hashed on its way and ends with DATA_LOSS where the disk held other bytes.
class BlobReadReactor final : public DownloadReactor<v1::BlobChunk> {
 public:
  BlobReadReactor(AssetStore& store, WorkPool& pool, StreamLimits& limits, const v1::ReadRequest& request);

 private:
  absl::Status Open() override;
  absl::StatusOr<bool> Next(v1::BlobChunk& chunk) override;
  std::optional<absl::Status> End() override;
  absl::Status Verify();

  AssetStore& store_;
  const v1::ReadRequest request_;
  Digest digest_;
  Sha256Stream hash_;
  uint64_t offset_ = 0, size_ = 0;
};

}  // namespace shutterline::server
