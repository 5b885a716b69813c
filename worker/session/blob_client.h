#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/container/flat_hash_set.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "common/base/clock.h"
#include "shutterline/v1/blobs.grpc.pb.h"
#include "worker/assets/blob_fetcher.h"
#include "worker/session/backoff.h"

namespace shutterline::worker {

/// Blobs from the coordinator. A coordinator that is away (restarting, say) is waited for, up to
/// `patience`, and a transfer that broke off goes on where it stopped: its absence must not count as a
/// failure of the tile. Thread-safe.
class BlobClient final : public BlobFetcher {
 public:
  struct Options {
    BackoffOptions backoff;
    absl::Duration patience = absl::Minutes(2);  ///< Without any progress.
  };

  BlobClient(std::shared_ptr<grpc::Channel> channel, const Options& options, const Clock& clock);

  absl::StatusOr<std::string> Fetch(const Digest& digest, uint64_t max_bytes) override;

  /// Ends all fetches, now and later, with CANCELLED.
  void Cancel();

 private:
  /// Appends what comes to `bytes`, which holds the beginning of the blob.
  absl::Status ReadOn(const Digest& digest, uint64_t max_bytes, std::string& bytes);

  const std::unique_ptr<v1::Blobs::StubInterface> stub_;
  const Options options_;
  const Clock& clock_;
  absl::Mutex mutex_;
  absl::CondVar changed_;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  absl::flat_hash_set<grpc::ClientContext*> calls_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::worker
