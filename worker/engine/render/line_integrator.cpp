#include "worker/engine/render/line_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>

#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "common/math/tolerance.h"
#include "worker/engine/render/make_resolver.h"
#include "worker/engine/render/stage_timer.h"
#include "worker/engine/shading/footprint.h"

namespace shutterline::engine {
namespace {

/// A pair's share of its pixel.
struct Contribution {
  uint64_t weight;
  V3f color;
};

/// An order that depends on what is added only, not on how triangles are numbered: sums of equal sets of
/// contributions are then equal to the last bit.
bool CanonicalOrder(const Contribution& a, const Contribution& b) {
  return std::tie(a.weight, a.color.x, a.color.y, a.color.z) <
         std::tie(b.weight, b.color.x, b.color.y, b.color.z);
}

}  // namespace

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
      required_traits_(traits_) {
  outputs_.Require(required_traits_);
}

void LineIntegrator::Render(const TileRect& rect, std::span<float> pixels, RenderStats& stats) const {
  SL_CHECK(int64_t(pixels.size()) == (4 + outputs_.channels()) * rect.Area());
  for (int y = 0; y < rect.height; y += kMaxLinePixels) {
    for (int x = 0; x < rect.width; x += kMaxLinePixels) {
      const TileRect part{rect.x + x, rect.y + y, std::min(kMaxLinePixels, rect.width - x),
                          std::min(kMaxLinePixels, rect.height - y)};
      RenderPart(part, rect, pixels, stats);
    }
  }
  ++stats.tiles;
}

void LineIntegrator::RenderPart(const TileRect& part, const TileRect& rect, std::span<float> pixels,
                                RenderStats& stats) const {
  StageTimer timer;
  std::vector<uint32_t> candidates;
  bvh_->CollectVisible(part, candidates);
  timer.Lap(stats.cull_seconds);

  stats.candidate_triangles += int64_t(candidates.size());
  PairWeights weights;
  TileTexels tile_texels(texels_, desks_, stats);
  ColorFilm film([this](uint32_t triangle) { return ColorsOf(triangle); },
                 [this](uint32_t triangle) { return GuessOf(triangle); }, &tile_texels);
  if (!outputs_.empty()) film.KeepPairs();
  const int64_t lines_before = stats.lines, instants_before = stats.instants;
  resolver_->Resolve({*frame_, required_traits_, part, candidates, this}, weights, &film, stats);
  timer.Lap(stats.resolve_seconds);

  const int64_t lines = stats.lines - lines_before;
  const double instants = lines > 0 ? double(stats.instants - instants_before) / double(lines) : 0;
  ShadePixels(part, weights, film, instants, rect, pixels, stats);
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

V3f LineIntegrator::GuessOf(uint32_t triangle) const {
  // A footprint as large as the triangle: the mean of its texture, about.
  constexpr Footprint kWhole{.db1_dx = 1, .db1_dy = 0, .db2_dx = 0, .db2_dy = 1, .rough = true};
  return shader_.ShadeInTheOpen(triangle, {1.0 / 3, 1.0 / 3}, kWhole);
}

void LineIntegrator::ShadePixels(const TileRect& part, const PairWeights& weights, const ColorFilm& film,
                                 double instants, const TileRect& rect, std::span<float> pixels,
                                 RenderStats& stats) const {
  std::vector<Contribution> contributions;
  std::vector<SeenPair> seen;
  TexelShader::Lately lately(shader_);
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      // Shade each pair once.
      contributions.clear();
      seen.clear();
      uint64_t covered = 0;
      weights.ForEach(int64_t{y} * part.width + x, [&](const PixelPair& pair) {
        const PrimitiveTraits& traits = traits_[frame_->triangles[pair.triangle].primitive];
        covered += pair.weight;
        Shaded shaded;
        if (traits.needs_position) {
          const Barycentric at{pair.b1 / double(pair.weight), pair.b2 / double(pair.weight)};
          shaded = texels_.Shade(pair.triangle, at, pair.MiddleTime(), lately, stats);
        } else {
          shaded = shader_.ShadeFully(pair.triangle, {}, {});
        }
        contributions.push_back({pair.weight, shaded.radiance});
        seen.push_back({pair, shaded.openness});
      });
      const std::array<double, 4>& film_sum = film.At(int64_t{y} * part.width + x);
      covered += uint64_t(film_sum[3]);
      SL_CHECK(covered <= weights.total());
      stats.pairs += int64_t(contributions.size());

      // Sum them in an order of their own, over the background, which is nothing.
      std::sort(contributions.begin(), contributions.end(), CanonicalOrder);
      double r = film_sum[0];
      double g = film_sum[1];
      double b = film_sum[2];
      for (const Contribution& c : contributions) {
        r += double(c.weight) * double(c.color.x);
        g += double(c.weight) * double(c.color.y);
        b += double(c.weight) * double(c.color.z);
      }
      const auto total = double(weights.total());
      const std::span<float> pixel = PixelOf(part, x, y, rect, pixels);
      pixel[0] = float(r / total);
      pixel[1] = float(g / total);
      pixel[2] = float(b / total);
      pixel[3] = float(double(covered) / total);
      if (outputs_.empty()) continue;
      film.pairs().ForEach(int64_t{y} * part.width + x, [&](const PixelPair& pair) {
        seen.push_back({pair, std::nullopt});
      });
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
