#pragma once

#include <absl/status/statusor.h>

#include <cstdint>

#include "common/job/job_spec.h"
#include "worker/engine/scene/asset_source.h"

namespace shutterline::client {

/// Names, sizes and digests of a scene's root file and of every file that it refers to, the root first, and
/// of its environment, if it has one, the last. Reads each file once. INVALID_ARGUMENT where a URI leaves the
/// root's folder, NOT_FOUND where a file is missing, RESOURCE_EXHAUSTED where one is larger than
/// `max_file_bytes`, and what ListExternalFiles refuses; messages name the scene, the file and the reason.
absl::StatusOr<SceneManifest> BuildManifest(const engine::AssetSource& source, uint64_t max_file_bytes);

}  // namespace shutterline::client
