#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "common/job/render_settings.h"
#include "worker/engine/accel/bvh.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/stochastic/cell_setup.h"
#include "worker/engine/stochastic/sample_keys.h"

namespace shutterline::engine {

/// `--integrator stochastic`: a rasterizer of moving triangles that tests point samples in (x, y, t), after
/// [akenine2007]. Every pixel is the mean of `settings.spp` samples (StratifiedPattern) under a box filter.
/// See docs/math/stochastic.md.
///
/// Pictures depend on the frame, `settings.spp` and `settings.seed` alone: they are equal to the last bit for
/// any rectangles, threads and processors.
class StochasticIntegrator final : public TileIntegrator {
 public:
  /// `frame` numbers the picture: with `settings.seed` it chooses the samples.
  static absl::StatusOr<std::unique_ptr<TileIntegrator>> Create(std::shared_ptr<const FrameScene> frame_scene,
                                                                int frame, const RenderSettings& settings,
                                                                int threads);
  ~StochasticIntegrator() override;

  void Render(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const override;

 private:
  /// What one thread needs while it renders a rectangle.
  struct Workspace;

  StochasticIntegrator(std::shared_ptr<const FrameScene> frame_scene, Shader shader, int frame,
                       const RenderSettings& settings, std::unique_ptr<const Bvh> bvh);

  void RenderCell(const TileRect& part, const TileRect& rect, std::span<float> rgba, RenderStats& stats,
                  Workspace& workspace) const;

  std::unique_ptr<Workspace> TakeWorkspace() const;
  void GiveBack(std::unique_ptr<Workspace> workspace) const;

  std::shared_ptr<const FrameScene> frame_;
  StratifiedPattern pattern_;
  std::unique_ptr<const Bvh> bvh_;
  Shader shader_;
  std::vector<PrimitiveTraits> traits_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> idle_;  ///< Guarded by mutex_.
};

}  // namespace shutterline::engine
