#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <optional>
#include <vector>

#include "worker/engine/accel/bvh.h"
#include "worker/engine/render/pair_shader.h"
#include "worker/engine/render/pixel_outputs.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/render/tile_texels.h"
#include "worker/engine/sampling/pixel_filter.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/shading/texel_shader.h"
#include "worker/engine/visibility/resolver.h"

namespace shutterline::engine {

/// The line-sample engine [gribel2011]: culls the frame's triangles against the tile, lets a resolver
/// decide what the tile's lines see over the shutter, shades each visible (triangle, pixel) pair once
/// and sums the pixels. Any rectangle will do; ones longer than kMaxLinePixels are cut. With a filter that is
/// wider than a pixel rectangles are grown by its reach, beyond the frame's edges too, and pairs and sums are
/// spread over the pixels that it reaches.
class LineIntegrator final : public TileIntegrator, private AlphaSource {
 public:
  static absl::StatusOr<std::unique_ptr<TileIntegrator>> Create(std::shared_ptr<const FrameScene> frame,
                                                                const RenderSettings& settings,
                                                                std::shared_ptr<ShadingCache> cache,
                                                                int threads);

  void Render(const TileRect& rect, std::span<float> pixels, RenderStats& stats) const override;

 private:
  LineIntegrator(std::shared_ptr<const FrameScene> frame, Shader shader, const RenderSettings& settings,
                 std::shared_ptr<ShadingCache> cache, std::unique_ptr<const Bvh> bvh);

  /// What a triangle looks like, if a few colours say it.
  std::optional<ColorNodes> ColorsOf(uint32_t triangle) const;
  double AlphaAt(uint32_t triangle, double b1, double b2, double t) const override;
  /// One colour that stands for the triangle, but where its texture moves.
  std::optional<V3f> GuessOf(uint32_t triangle) const;
  void RenderPart(const TileRect& part, const TileRect& rect, std::span<float> pixels,
                  RenderStats& stats) const;
  /// `instants`: of a line, on average.
  void ShadePixels(const TileRect& part, const PairWeights& weights, const ColorFilm& film, double instants,
                   const TileRect& rect, std::span<float> pixels, RenderStats& stats) const;
  /// The same where pairs and film are those of the part grown by the filter's reach.
  void SpreadPixels(const TileRect& part, const PairWeights& weights, const ColorFilm& film, double instants,
                    const TileRect& rect, std::span<float> pixels, RenderStats& stats) const;
  /// All channels of pixel (x, y) of `part`, in the pixels of `rect`.
  std::span<float> PixelOf(const TileRect& part, int x, int y, const TileRect& rect,
                           std::span<float> pixels) const;

  std::shared_ptr<const FrameScene> frame_;
  std::unique_ptr<const Bvh> bvh_;
  Shader shader_;
  TexelShader texels_;
  mutable TexelDesks desks_;
  PixelOutputs outputs_;
  std::unique_ptr<const Resolver> resolver_;
  std::optional<PixelFilter> filter_;    ///< None: pixels see what lies within them.
  std::vector<PrimitiveTraits> traits_;  ///< What shading needs.
  PairShader pairs_;
  std::vector<PrimitiveTraits> required_traits_;  ///< The same and what outputs need.
};

}  // namespace shutterline::engine
