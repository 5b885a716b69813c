#pragma once

#include <map>
#include <string>

#include "worker/engine/scene/asset_source.h"

namespace shutterline::engine {

/// Files in memory by their relative names ("fox.gltf", "textures/fur.png"). Immutable: any number of
/// threads may read it.
class MemoryAssetSource : public AssetSource {
 public:
  MemoryAssetSource(std::string root_name, std::map<std::string, std::string> files);

  const std::string& RootName() const override { return root_name_; }
  absl::StatusOr<std::string> Read(absl::string_view relative_uri, uint64_t max_bytes) const override;

 private:
  const std::string root_name_;
  const std::map<std::string, std::string> files_;
};

}  // namespace shutterline::engine
