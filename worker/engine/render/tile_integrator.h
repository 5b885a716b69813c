#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <span>

#include "common/job/render_settings.h"
#include "common/job/tile.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// Renders tiles of one frame by one method. Built once a frame, shared by all threads.
class TileIntegrator {
 public:
  virtual ~TileIntegrator() = default;

  /// Renders the pixels of `rect`, which lies within the frame, into `pixels`, rows from the top: as many
  /// floats a pixel as OutputChannelCount says for the settings, the first four linear premultiplied RGBA.
  /// Thread-safe. What is written depends on nothing but the frame, the settings and `rect`. Adds to `stats`,
  /// which belongs to the caller.
  virtual void Render(const TileRect& rect, std::span<float> pixels, RenderStats& stats) const = 0;
};

class ShadingCache;

/// The integrator that `settings.integrator` names, ready to render `frame` (for the reference and the
/// stochastic integrator the frame number seeds the samples). Builds what the method needs, as its BVH, with
/// up to `threads` threads. Of `cache`, which may be null, only speed depends.
absl::StatusOr<std::unique_ptr<TileIntegrator>> MakeTileIntegrator(
    std::shared_ptr<const FrameScene> frame_scene, int frame, const RenderSettings& settings, int threads,
    std::shared_ptr<ShadingCache> cache = nullptr);

}  // namespace shutterline::engine
