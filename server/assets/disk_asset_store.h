#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <set>

#include "common/base/clock.h"
#include "server/assets/asset_store.h"
#include "server/assets/blob_ledger.h"
#include "server/files/durability.h"

namespace shutterline::server {

/// AssetStore in a folder: blobs/<first two digits>/<digest> for blobs, incoming/<digest> for what is being
/// written. Blobs become visible by rename, after a flush. A blob's file has the time of its last use, so
/// that a later process knows which are old.
class DiskAssetStore final : public AssetStore {
 public:
  struct Options {
    uint64_t max_blob_bytes = UINT64_MAX;
    /// Of all blobs together, as far as pinned and recently used ones allow; 0: no limit. Writes are refused
    /// where it would be passed.
    uint64_t limit_bytes = 0;
    absl::Duration grace = absl::Minutes(10);  ///< What was used so recently is not evicted.
    Durability durability = Durability::kPower;
  };
  static absl::StatusOr<std::unique_ptr<DiskAssetStore>> Open(const std::string& folder,
                                                              const Options& options,
                                                              const Clock& clock = Clock::System());

  absl::StatusOr<CommittedBlob> Query(const Digest& digest) override;
  absl::StatusOr<std::unique_ptr<BlobWriter>> Write(const Digest& digest, uint64_t size,
                                                    uint64_t offset) override;
  absl::StatusOr<uint64_t> Size(const Digest& digest) override;
  absl::StatusOr<std::string> Read(const Digest& digest, uint64_t offset, size_t count) override;
  absl::StatusOr<std::string> ReadVerified(const Digest& digest, uint64_t max_bytes) override;
  void ReportDamage(const Digest& digest) override;
  std::shared_ptr<const BlobPins> Pin(std::vector<Digest> digests) override;

  /// Bytes that blobs take, and what is being written.
  uint64_t bytes() const;

 private:
  class Writer;
  class Pins;
  DiskAssetStore(std::string folder, const Options& options, const Clock& clock)
      : folder_(std::move(folder)), options_(options), clock_(clock), ledger_(options.grace) {}
  std::string BlobPath(const Digest& digest) const;
  std::string IncomingPath(const Digest& digest) const;
  absl::Status ReadFolder();
  /// Evicts until `size` more bytes fit, and takes them.
  absl::Status Reserve(const Digest& digest, uint64_t size) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status Evict(const Digest& digest) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Release(const Digest& digest, uint64_t bytes_left);

  const std::string folder_;
  const Options options_;
  const Clock& clock_;
  mutable absl::Mutex mutex_;
  std::set<Digest> being_written_ ABSL_GUARDED_BY(mutex_);
  BlobLedger ledger_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::server
