#pragma once

#include <absl/status/statusor.h>

#include <memory>

#include "common/math/spaces.h"
#include "worker/engine/accel/embree_frame.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// Who stands in whose light, at mid-shutter, when surfaces are lit: by rays against a frame's triangles,
/// both sides of each. Layers cast no shadow. Immutable; any number of threads may ask, and the answer
/// depends on the question alone.
class Shadows {
 public:
  static absl::StatusOr<std::shared_ptr<const Shadows>> Build(const FrameScene& frame);

  /// Whether something lies between a point of a surface, whose triangle faces `face`, and a light at
  /// `distance` (which may be infinite) towards the unit vector `to_light`, on the same side. View space,
  /// metres.
  bool IsShadowed(const V3d& position, const V3d& face, const V3d& to_light, double distance) const;

 private:
  explicit Shadows(EmbreeFrame embree) : embree_(std::move(embree)) {}

  EmbreeFrame embree_;
};

}  // namespace shutterline::engine
