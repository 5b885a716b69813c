#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <vector>

#include "common/job/render_settings.h"
#include "worker/engine/accel/embree_frame.h"
#include "worker/engine/reference/hit_shader.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/sampling/filter_points.h"
#include "worker/engine/sampling/point_pattern.h"

namespace shutterline::engine {

/// `--reference-layout shared-instants`: rays whose times all pixels share, one random instant in each of
/// `settings.spp` equal strata of the shutter; places in a pixel are EmbreeTracer's. At an instant nothing
/// moves, so rays meet a tree of its own without motion, in packets of neighbouring pixels: several times
/// faster than one tree over all the motion. Each pixel is estimated without bias and its error is that of
/// a net in three dimensions, but errors of neighbours go together: few samples show as ghosts, and an
/// estimate of noise that takes pixels as independent is too small. For the judge that is the wrong layout,
/// as a rival the right one.
class InstantTracer final : public TileIntegrator {
 public:
  /// All trees are held at once. False where they would take more than kMostBytes, roughly: then
  /// EmbreeTracer serves. Depends on nothing but the frame and spp.
  static bool Fits(const FrameScene& frame, int spp);
  static constexpr double kMostBytes = 2.0 * (1u << 30);

  /// Builds the trees with up to `threads` threads. Errors as EmbreeTracer::Create.
  static absl::StatusOr<std::unique_ptr<TileIntegrator>> Create(
      std::shared_ptr<const FrameScene> frame_scene, int frame, const RenderSettings& settings, int threads,
      std::shared_ptr<ShadingCache> cache = nullptr);

  void Render(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const override;

 private:
  InstantTracer(std::shared_ptr<const FrameScene> frame_scene, Shader shader,
                std::shared_ptr<ShadingCache> cache, int frame, const RenderSettings& settings);

  template <int kWidth>
  void RenderTile(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const;

  std::shared_ptr<const FrameScene> frame_scene_;
  HitShader shader_;
  PointPattern pattern_;
  FilterPoints filter_;
  int spp_;
  std::vector<double> instants_;     ///< By stratum.
  std::vector<EmbreeFrame> scenes_;  ///< By stratum; one for all where nothing moves.
};

}  // namespace shutterline::engine
