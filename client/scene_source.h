#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "worker/engine/scene/asset_source.h"

namespace shutterline::client {

/// A scene file with the files beside it and, where `environment_path` is not empty, the picture there as its
/// environment (engine::kEnvironmentFile). Errors name the file. Without an environment of ours, a file of
/// that name beside the scene is not offered.
absl::StatusOr<std::unique_ptr<engine::AssetSource>> OpenSceneSource(const std::string& scene_path,
                                                                     const std::string& environment_path);

}  // namespace shutterline::client
