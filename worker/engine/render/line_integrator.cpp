#include "worker/engine/render/line_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "common/math/tolerance.h"
#include "worker/engine/render/make_resolver.h"
#include "worker/engine/render/pixel_sum.h"
#include "worker/engine/render/spread_pairs.h"
#include "worker/engine/render/stage_timer.h"
#include "worker/engine/shading/footprint.h"

namespace shutterline::engine {

absl::StatusOr<std::unique_ptr<TileIntegrator>> LineIntegrator::Create(
    std::shared_ptr<const FrameScene> frame, const RenderSettings& settings,
    std::shared_ptr<ShadingCache> cache, int threads) {
  SL_ASSIGN_OR_RETURN(Shader shader, Shader::Create(frame, settings, threads));
  if (settings.resolver == ResolverKind::kPaper) {
    SL_RETURN_IF_ERROR(shader.CheckOpaque("resolver paper"));
    if (!settings.shutter_curve.empty()) {
      return absl::UnimplementedError("resolver paper: it knows no shutter curve but box");
    }
  }
  SL_ASSIGN_OR_RETURN(std::unique_ptr<const Bvh> bvh, Bvh::Build(frame, threads));
  return std::unique_ptr<TileIntegrator>(
      new LineIntegrator(std::move(frame), std::move(shader), settings, std::move(cache), std::move(bvh)));
}

LineIntegrator::LineIntegrator(std::shared_ptr<const FrameScene> frame, Shader shader,
                               const RenderSettings& settings, std::shared_ptr<ShadingCache> cache,
                               std::unique_ptr<const Bvh> bvh)
    : frame_(std::move(frame)),
      bvh_(std::move(bvh)),
      shader_(std::move(shader)),
      texels_(shader_, settings, std::move(cache)),
      outputs_(shader_, texels_, settings),
      resolver_(MakeResolver(settings)),
      traits_(shader_.Traits()),
      pairs_(shader_, texels_, traits_),
      required_traits_(traits_) {
  if (!HasPixelBox(settings)) filter_.emplace(settings.filter, FilterRadius(settings));
  outputs_.Require(required_traits_);
}

void LineIntegrator::Render(const TileRect& rect, std::span<float> pixels, RenderStats& stats) const {
  SL_CHECK(int64_t(pixels.size()) == (4 + outputs_.channels()) * rect.Area());
  const int most = kMaxLinePixels - (filter_ ? 2 * filter_->reach() : 0);
  for (int y = 0; y < rect.height; y += most) {
    for (int x = 0; x < rect.width; x += most) {
      const TileRect part{rect.x + x, rect.y + y, std::min(most, rect.width - x),
                          std::min(most, rect.height - y)};
      RenderPart(part, rect, pixels, stats);
    }
  }
  ++stats.tiles;
}

void LineIntegrator::RenderPart(const TileRect& part, const TileRect& rect, std::span<float> pixels,
                                RenderStats& stats) const {
  StageTimer timer;
  const int apron = filter_ ? filter_->reach() : 0;
  const TileRect grown{part.x - apron, part.y - apron, part.width + 2 * apron, part.height + 2 * apron};
  std::vector<uint32_t> candidates;
  bvh_->CollectVisible(grown, candidates);
  timer.Lap(stats.cull_seconds);

  stats.candidate_triangles += int64_t(candidates.size());
  PairWeights weights;
  TileTexels tile_texels(texels_, desks_, stats);
  ColorFilm film([this](uint32_t triangle) { return ColorsOf(triangle); },
                 [this](uint32_t triangle) { return GuessOf(triangle); }, &tile_texels);
  if (!outputs_.empty()) film.KeepPairs();
  const int64_t lines_before = stats.lines, instants_before = stats.instants;
  resolver_->Resolve({*frame_, required_traits_, grown, candidates, this, filter_ ? &*filter_ : nullptr},
                     weights, &film, stats);
  timer.Lap(stats.resolve_seconds);

  const int64_t lines = stats.lines - lines_before;
  const double instants = lines > 0 ? double(stats.instants - instants_before) / double(lines) : 0;
  if (filter_) {
    SpreadPixels(part, weights, film, instants, rect, pixels, stats);
  } else {
    ShadePixels(part, weights, film, instants, rect, pixels, stats);
  }
  timer.Lap(stats.shade_seconds);
}

std::optional<ColorNodes> LineIntegrator::ColorsOf(uint32_t triangle) const {
  const uint32_t primitive = frame_->triangles[triangle].primitive;
  const PrimitiveTraits& traits = traits_[primitive];
  // A highlight is narrower than what a few points tell, and so is what occludes.
  if (traits.textured || traits.glossy || shader_.IsDear(*frame_->primitives[primitive].material)) {
    return std::nullopt;
  }
  const auto shade = [&](double b1, double b2) { return shader_.Shade(triangle, {b1, b2}, {}); };
  const V3f first = shade(0, 0);
  ColorNodes nodes;
  nodes.corners = {first, first, first};
  if (!traits.needs_position) return nodes;
  // Without textures shading is smooth: a polynomial that is right in the middle is right enough.
  nodes.corners = {first, shade(1, 0), shade(0, 1)};
  const V3f middle = shade(1.0 / 3, 1.0 / 3);
  const auto is_near = [&](const V3f& guess) {
    constexpr float kTolerance = 1e-3f;
    for (int c = 0; c < 3; ++c) {
      if (!(std::abs(guess[c] - middle[c]) < kTolerance * std::max(1.0f, middle[c]))) return false;
    }
    return true;
  };
  const V3f corners = nodes.corners[0] + nodes.corners[1] + nodes.corners[2];
  if (is_near(corners / 3.0f)) return nodes;
  nodes.quadratic = true;
  nodes.middles = {shade(0.5, 0), shade(0.5, 0.5), shade(0, 0.5)};
  const V3f middles = nodes.middles[0] + nodes.middles[1] + nodes.middles[2];
  if (is_near((4.0f * middles - corners) / 9.0f)) return nodes;
  return std::nullopt;
}

double LineIntegrator::AlphaAt(uint32_t triangle, double b1, double b2, double t) const {
  const Barycentric at{b1, b2};
  return shader_.Alpha(triangle, at, PixelFootprintAt(*frame_, triangle, at, t));
}

std::optional<V3f> LineIntegrator::GuessOf(uint32_t triangle) const {
  // A texture that moves differs from instant to instant by itself. Light does too, but hardly.
  if (traits_[frame_->triangles[triangle].primitive].textured && texels_.HasTexels(triangle)) {
    return std::nullopt;
  }
  // A footprint as large as the triangle: the mean of its texture, about.
  constexpr Footprint kWhole{.db1_dx = 1, .db1_dy = 0, .db2_dx = 0, .db2_dy = 1, .rough = true};
  return shader_.ShadeInTheOpen(triangle, {1.0 / 3, 1.0 / 3}, kWhole);
}

void LineIntegrator::ShadePixels(const TileRect& part, const PairWeights& weights, const ColorFilm& film,
                                 double instants, const TileRect& rect, std::span<float> pixels,
                                 RenderStats& stats) const {
  PixelSum sum;
  std::vector<SeenPair> seen;
  const std::vector<Shaded> shaded = pairs_.ShadeAll(weights, stats);
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      sum.Clear();
      seen.clear();
      weights.ForEach(int64_t{y} * part.width + x, [&](const PixelPair& pair) {
        const Shaded& of_pair = shaded[weights.NumberOf(pair)];
        sum.Add(pair.weight, of_pair.radiance);
        if (!outputs_.empty()) seen.push_back(outputs_.Look(pair, of_pair.openness, stats));
      });
      const std::span<float> pixel = PixelOf(part, x, y, rect, pixels);
      sum.Write(film.At(int64_t{y} * part.width + x), weights.total(), pixel);
      if (outputs_.empty()) continue;
      film.pairs().ForEach(int64_t{y} * part.width + x, [&](const PixelPair& pair) {
        seen.push_back(outputs_.Look(pair, std::nullopt, stats));
      });
      outputs_.Write(seen, weights.total(), instants, pixel.subspan(4), stats);
    }
  }
}

void LineIntegrator::SpreadPixels(const TileRect& part, const PairWeights& weights, const ColorFilm& film,
                                  double instants, const TileRect& rect, std::span<float> pixels,
                                  RenderStats& stats) const {
  const int reach = filter_->reach();
  const SpreadPairs::Grid grid{part.width + 2 * reach, part.height + 2 * reach, reach};
  const std::vector<Shaded> shaded = pairs_.ShadeAll(weights, stats);
  std::vector<SeenPair> looks(outputs_.empty() ? 0 : weights.Count() + 1);
  const SpreadPairs apart(grid, weights);
  if (!outputs_.empty()) {
    apart.ForAll([&](uint32_t number, const PixelPair& pair) {
      looks[number] = outputs_.Look(pair, shaded[number].openness, stats);
    });
  }
  const SpreadPairs colored(grid, film.pairs());
  std::vector<SeenPair> colored_looks;
  if (!outputs_.empty()) {
    colored_looks.resize(film.pairs().Count() + 1);
    colored.ForAll([&](uint32_t number, const PixelPair& pair) {
      colored_looks[number] = outputs_.Look(pair, std::nullopt, stats);
    });
  }

  PixelSum sum;
  std::vector<SeenPair> seen;
  const auto see = [&](SeenPair look, uint64_t weight) {
    look.weight = weight;
    seen.push_back(look);
  };
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      sum.Clear();
      seen.clear();
      apart.ForReaching(x, y, [&](uint32_t number, uint64_t weight) {
        sum.Add(weight, shaded[number].radiance);
        if (!outputs_.empty()) see(looks[number], weight);
      });
      const std::span<float> pixel = PixelOf(part, x, y, rect, pixels);
      sum.Write(film.At(grid.At(x + reach, y + reach)), weights.total(), pixel);
      if (outputs_.empty()) continue;
      colored.ForReaching(x, y,
                          [&](uint32_t number, uint64_t weight) { see(colored_looks[number], weight); });
      outputs_.Write(seen, weights.total(), instants, pixel.subspan(4), stats);
    }
  }
}

std::span<float> LineIntegrator::PixelOf(const TileRect& part, int x, int y, const TileRect& rect,
                                         std::span<float> pixels) const {
  const size_t pixel = size_t(part.y - rect.y + y) * size_t(rect.width) + size_t(part.x - rect.x + x);
  const size_t channels = 4 + size_t(outputs_.channels());
  return pixels.subspan(pixel * channels, channels);
}

}  // namespace shutterline::engine
