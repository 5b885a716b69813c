#pragma once

#include <string>

#include "common/job/job_spec.h"
#include "server/assets/asset_store.h"
#include "worker/engine/scene/asset_source.h"

namespace shutterline::server {

/// A scene's files, read from the blobs that its manifest names. The store outlives it. Thread-safe.
class BlobSceneSource final : public engine::AssetSource {
 public:
  BlobSceneSource(const SceneManifest& manifest, AssetStore& store) : manifest_(manifest), store_(store) {}

  const std::string& RootName() const override { return manifest_.root_name; }
  absl::StatusOr<std::string> Read(absl::string_view relative_uri, uint64_t max_bytes) const override;

 private:
  const SceneManifest manifest_;
  AssetStore& store_;
};

}  // namespace shutterline::server
