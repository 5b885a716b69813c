#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>

#include "worker/engine/scene/gltf_budget.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Decodes a PNG or JPEG picture, told by its first bytes, to RGBA of 8 bits a channel, or of 16 for a PNG
/// that has them, whose pixels count twice. Its size is read from its header and held against the limits,
/// and against what so few bytes can encode, before any pixel gets memory; the decoder's own memory is
/// bounded too.
absl::StatusOr<TextureImage> DecodeGltfImage(absl::string_view bytes, uint32_t max_side, GltfBudget* pixels);

}  // namespace shutterline::engine
