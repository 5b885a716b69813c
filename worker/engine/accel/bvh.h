#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "common/job/tile.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// A bounding volume hierarchy over the triangles of a frame, each bounded over the shutter by the hull of
/// its control points, or, where its motion is long, over several spans of it (SpansFor). Answers which
/// triangles a tile may see. Immutable once built; any number of threads may query it.
class Bvh {
 public:
  virtual ~Bvh() = default;

  /// Builds with up to `threads` threads. RESOURCE_EXHAUSTED where memory is not enough.
  static absl::StatusOr<std::unique_ptr<const Bvh>> Build(std::shared_ptr<const FrameScene> frame,
                                                          int threads);

  /// Appends to `triangles` every triangle that, at some instant of the shutter, may be seen through
  /// `rect` between the near and the far plane: none is missed, few are superfluous, each comes once.
  /// Neither which ones nor their order depends on the number of threads of the build.
  virtual void CollectVisible(const TileRect& rect, std::vector<uint32_t>& triangles) const = 0;
};

}  // namespace shutterline::engine
