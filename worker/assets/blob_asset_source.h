#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/asset/digest.h"
#include "common/job/job_spec.h"
#include "worker/assets/asset_cache.h"
#include "worker/assets/blob_fetcher.h"
#include "worker/engine/scene/asset_source.h"

namespace shutterline::worker {

/// A scene's files as blobs: what the importer may read is what the job's manifest lists, nothing else,
/// whatever paths the files contain. Pins its blobs in the cache while it lives. Thread-safe.
class BlobAssetSource final : public engine::AssetSource {
 public:
  /// INVALID_ARGUMENT where the manifest does not list its root, or lists a name twice or one that is
  /// absolute or leaves the folder. `cache` and `fetcher` must outlive the source.
  static absl::StatusOr<std::unique_ptr<BlobAssetSource>> Make(const SceneManifest& scene, AssetCache& cache,
                                                               BlobFetcher& fetcher);

  const std::string& RootName() const override { return root_; }
  absl::StatusOr<std::string> Read(absl::string_view relative_uri, uint64_t max_bytes) const override;

 private:
  BlobAssetSource(std::string root, AssetCache& cache, BlobFetcher& fetcher)
      : root_(std::move(root)), cache_(cache), fetcher_(fetcher) {}

  const std::string root_;
  AssetCache& cache_;
  BlobFetcher& fetcher_;
  absl::flat_hash_map<std::string, Digest> blobs_;  // By normalised path.
  std::vector<std::unique_ptr<AssetCache::Pin>> pins_;
};

/// `path` without "." and ".." parts. INVALID_ARGUMENT where it is empty, absolute (also by a scheme or
/// a drive letter, as "http:" or "C:"), has a backslash or a zero byte, or leaves its folder.
absl::StatusOr<std::string> NormalizeRelativePath(absl::string_view path);

}  // namespace shutterline::worker
