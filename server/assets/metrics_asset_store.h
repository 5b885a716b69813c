#pragma once

#include <functional>
#include <utility>

#include "server/assets/asset_store.h"

namespace shutterline::server {

/// An AssetStore that counts the bytes that are appended to blobs and read from them in pieces, as uploads
/// and downloads do. As thread-safe as the store that it wraps, which outlives it.
class MetricsAssetStore final : public AssetStore {
 public:
  /// Called with the bytes that came in, and that went out, in this call; from any thread.
  using Count = std::function<void(uint64_t received, uint64_t sent)>;
  MetricsAssetStore(AssetStore& store, Count count) : store_(store), count_(std::move(count)) {}

  absl::StatusOr<CommittedBlob> Query(const Digest& digest) override { return store_.Query(digest); }
  absl::StatusOr<std::unique_ptr<BlobWriter>> Write(const Digest& digest, uint64_t size,
                                                    uint64_t offset) override;
  absl::StatusOr<uint64_t> Size(const Digest& digest) override { return store_.Size(digest); }
  absl::StatusOr<std::string> Read(const Digest& digest, uint64_t offset, size_t count) override;
  absl::StatusOr<std::string> ReadVerified(const Digest& digest, uint64_t max_bytes) override {
    return store_.ReadVerified(digest, max_bytes);
  }
  void ReportDamage(const Digest& digest) override { store_.ReportDamage(digest); }
  std::shared_ptr<const BlobPins> Pin(std::vector<Digest> digests) override {
    return store_.Pin(std::move(digests));
  }

 private:
  AssetStore& store_;
  const Count count_;
};

}  // namespace shutterline::server
