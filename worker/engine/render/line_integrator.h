#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <optional>
#include <vector>

#include "worker/engine/accel/bvh.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/visibility/resolver.h"

namespace shutterline::engine {

/// The line-sample engine [gribel2011]: culls the frame's triangles against the tile, lets a resolver
/// decide what the tile's lines see over the shutter, shades each visible (triangle, pixel) pair once
/// and sums the pixels. Any rectangle will do; ones longer than kMaxLinePixels are cut.
class LineIntegrator final : public TileIntegrator, private AlphaSource {
 public:
  static absl::StatusOr<std::unique_ptr<TileIntegrator>> Create(std::shared_ptr<const FrameScene> frame,
                                                                const RenderSettings& settings, int threads);

  void Render(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const override;

 private:
  LineIntegrator(std::shared_ptr<const FrameScene> frame, Shader shader, const RenderSettings& settings,
                 std::unique_ptr<const Bvh> bvh);

  /// What a triangle looks like, if a few colours say it.
  std::optional<ColorNodes> ColorsOf(uint32_t triangle) const;
  double AlphaAt(uint32_t triangle, double b1, double b2, double t) const override;
  /// One colour that stands for the triangle.
  V3f GuessOf(uint32_t triangle) const;
  void RenderPart(const TileRect& part, const TileRect& rect, std::span<float> rgba,
                  RenderStats& stats) const;
  void ShadePixels(const TileRect& part, const PairWeights& weights, const ColorFilm& film,
                   const TileRect& rect, std::span<float> rgba, RenderStats& stats) const;

  std::shared_ptr<const FrameScene> frame_;
  std::unique_ptr<const Bvh> bvh_;
  Shader shader_;
  std::unique_ptr<const Resolver> resolver_;
  std::vector<PrimitiveTraits> traits_;
};

}  // namespace shutterline::engine
