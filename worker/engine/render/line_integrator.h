#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <vector>

#include "worker/engine/accel/bvh.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/visibility/resolver.h"

namespace shutterline::engine {

/// The line-sample engine [gribel2011]: culls the frame's triangles against the tile, lets a resolver
/// decide what the tile's lines see over the shutter, shades each visible (triangle, pixel) pair once
/// and sums the pixels. Any rectangle will do; ones longer than kMaxLinePixels are cut.
class LineIntegrator final : public TileIntegrator {
 public:
  static absl::StatusOr<std::unique_ptr<TileIntegrator>> Create(std::shared_ptr<const FrameScene> frame,
                                                                const RenderSettings& settings, int threads);

  void Render(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const override;

 private:
  LineIntegrator(std::shared_ptr<const FrameScene> frame, const RenderSettings& settings,
                 std::unique_ptr<const Bvh> bvh);

  /// The colours at a triangle's corners, if they say what it looks like in between.
  ColorFilm::CornerColors CornerColors(uint32_t triangle) const;
  void RenderPart(const TileRect& part, const TileRect& rect, std::span<float> rgba,
                  RenderStats& stats) const;
  void ShadePixels(const TileRect& part, const PairWeights& weights, const ColorFilm& film,
                   const TileRect& rect, std::span<float> rgba, RenderStats& stats) const;

  std::shared_ptr<const FrameScene> frame_;
  std::unique_ptr<const Bvh> bvh_;
  std::unique_ptr<const Resolver> resolver_;
  std::vector<PrimitiveTraits> traits_;
};

}  // namespace shutterline::engine
