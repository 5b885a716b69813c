#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include <set>

#include "server/assets/asset_store.h"

namespace shutterline::server {

/// AssetStore in a folder: blobs/<first two digits>/<digest> for blobs, incoming/<digest> for what is being
/// written. Blobs become visible by rename, after a flush.
class DiskAssetStore final : public AssetStore {
 public:
  static absl::StatusOr<std::unique_ptr<DiskAssetStore>> Open(const std::string& folder,
                                                              uint64_t max_blob_bytes);

  absl::StatusOr<CommittedBlob> Query(const Digest& digest) override;
  absl::StatusOr<std::unique_ptr<BlobWriter>> Write(const Digest& digest, uint64_t size,
                                                    uint64_t offset) override;
  absl::StatusOr<uint64_t> Size(const Digest& digest) override;
  absl::StatusOr<std::string> Read(const Digest& digest, uint64_t offset, size_t count) override;
  absl::StatusOr<std::string> ReadVerified(const Digest& digest, uint64_t max_bytes) override;
  void ReportDamage(const Digest& digest) override;

 private:
  class Writer;
  DiskAssetStore(std::string folder, uint64_t max_blob_bytes)
      : folder_(std::move(folder)), max_blob_bytes_(max_blob_bytes) {}
  std::string BlobPath(const Digest& digest) const;
  std::string IncomingPath(const Digest& digest) const;
  void Release(const Digest& digest);

  const std::string folder_;
  const uint64_t max_blob_bytes_;
  absl::Mutex mutex_;
  std::set<Digest> being_written_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::server
