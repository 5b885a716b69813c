#pragma once

#include <absl/status/statusor.h>

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// The lights (KHR_lights_punctual) of a document that has passed `ConformToGltfSchema`. Read from the JSON,
/// because the typed model cannot tell a range of 0, which is an error, from none.
///
/// A spot whose cones are equal is taken: it has a hard edge, and exporters write it.
absl::StatusOr<std::vector<PunctualLight>> ReadGltfLights(const nlohmann::json& conforming);

}  // namespace shutterline::engine
