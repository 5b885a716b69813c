#pragma once

#include <absl/status/statusor.h>

#include <memory>

#include "common/job/render_settings.h"
#include "worker/engine/accel/embree_frame.h"
#include "worker/engine/reference/hit_shader.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/sampling/filter_points.h"
#include "worker/engine/sampling/point_pattern.h"
#include "worker/engine/sampling/shutter_curve.h"

namespace shutterline::engine {

/// `--integrator reference`: ground truth by point samples. Every pixel is the mean of `settings.spp` rays at
/// low-discrepancy points in (x, y, t), traced by Embree against triangles that move
/// linearly over the shutter. The motion model is that of the line integrator: homogeneous raster space is
/// a constant linear map of view space. Surfaces are hit between the near and the far plane; those seen
/// from behind are passed where their material is not double-sided, facing being that at the ray's own
/// time; of triangles at equal distance the lowest number is seen. Shading is evaluated at each hit.
///
/// Triangles are intersected in single precision, rays are made and samples summed in double. A pixel
/// depends on nothing but its place, the frame, the seed and spp. It is bit-identical for any tiles and
/// threads; processors whose Embree kernels differ (with and without fused multiplication) may decide
/// single rays at the edge of a triangle differently.
class EmbreeTracer : public TileIntegrator {
 public:
  /// `frame` numbers the picture: with `settings.seed` it chooses the samples. Builds Embree's tree with up
  /// to `threads` threads. RESOURCE_EXHAUSTED or INTERNAL where Embree fails.
  static absl::StatusOr<std::unique_ptr<EmbreeTracer>> Create(std::shared_ptr<const FrameScene> frame_scene,
                                                              int frame, const RenderSettings& settings,
                                                              int threads,
                                                              std::shared_ptr<ShadingCache> cache = nullptr);

  void Render(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const override;

 private:
  EmbreeTracer(std::shared_ptr<const FrameScene> frame_scene, Shader shader, EmbreeFrame embree,
               std::shared_ptr<ShadingCache> cache, int frame, const RenderSettings& settings);

  template <int kWidth>
  void RenderPixels(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const;

  std::shared_ptr<const FrameScene> frame_scene_;
  EmbreeFrame embree_;
  HitShader shader_;
  PointPattern pattern_;
  FilterPoints filter_;
  ShutterCurve shutter_;
  int spp_;
};

}  // namespace shutterline::engine
