#include "tests/fuzz/resolver_checks.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/support/only_target.h"
#include "tests/support/scalar_resolver.h"
#include "worker/engine/render/make_resolver.h"
#include "worker/engine/slice/kernels.h"
#include "worker/engine/slice/resolver_slice.h"
#include "worker/engine/visibility/segment.h"

namespace shutterline::engine {
namespace {

/// Barycentric coordinates are means of clamped ones.
constexpr double kPositionSlack = 1e-9;
/// Ends of segments are rounded to subpixels; there are a few hundred in a pixel at most.
constexpr double kEndsSlack = 1e-5;

struct Pair {
  uint64_t weight = 0;
  double b1 = 0, b2 = 0;
  friend bool operator==(const Pair&, const Pair&) = default;
};

/// All that a resolver says of a tile.
struct Result {
  std::map<std::tuple<int64_t, uint32_t, uint16_t>, Pair> pairs;
  std::vector<std::array<double, 4>> film;
  uint64_t total = 0;
  friend bool operator==(const Result&, const Result&) = default;

  std::vector<uint64_t> Covered(int64_t pixels) const {
    std::vector<uint64_t> covered(size_t(pixels), 0);
    for (const auto& [key, pair] : pairs) covered[size_t(std::get<0>(key))] += pair.weight;
    return covered;
  }
};

std::vector<uint32_t> AllOf(const FrameScene& frame) {
  std::vector<uint32_t> all(frame.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

std::vector<PrimitiveTraits> TraitsOf(const FrameScene& frame, bool needs_position) {
  std::vector<PrimitiveTraits> traits;
  for (const FramePrimitive& primitive : frame.primitives) {
    traits.push_back({.cull_back = !primitive.material->double_sided, .needs_position = needs_position});
  }
  return traits;
}

ColorFilm MakeFilm() {
  return ColorFilm([](uint32_t triangle) -> std::optional<ColorNodes> {
    // Constant, linear, quadratic or apart.
    const V3f color(1.0f / float(triangle + 1), 0.5f, 0.25f);
    const V3f other = triangle % 4 == 0 ? color : V3f(0, 1, 0);
    if (triangle % 4 == 3) return std::nullopt;
    return ColorNodes{.corners = {color, color, other},
                      .middles = {color, color, V3f(0.5f, 0.5f, 0.5f)},
                      .quadratic = triangle % 4 == 2};
  });
}

Result Resolve(const Resolver& resolver, const HostileFrame& input, bool film,
               const std::vector<uint32_t>& candidates) {
  PairWeights weights;
  ColorFilm colors = MakeFilm();
  RenderStats stats;
  const std::vector<PrimitiveTraits> traits = TraitsOf(*input.frame, true);
  resolver.Resolve({*input.frame, traits, input.rect, candidates}, weights, film ? &colors : nullptr, stats);
  Result result;
  result.total = weights.total();
  for (int64_t pixel = 0; pixel < input.rect.Area(); ++pixel) {
    weights.ForEach(pixel, [&](const PixelPair& p) {
      result.pairs[{pixel, p.triangle, p.bin}] = {p.weight, p.b1, p.b2};
    });
    if (film) result.film.push_back(colors.At(pixel));
  }
  return result;
}

std::string At(const TileRect& rect, int64_t pixel) {
  return absl::StrCat(" in pixel (", pixel % rect.width, ", ", pixel / rect.width, ")");
}

/// What is wrong with a result by itself.
std::string Broken(const Result& result, const HostileFrame& input, bool positions) {
  for (const auto& [key, pair] : result.pairs) {
    const auto& [pixel, triangle, bin] = key;
    const std::string where = absl::StrCat(" of triangle ", triangle, At(input.rect, pixel));
    if (triangle >= input.frame->triangles.size()) return "number" + where;
    if (!positions) continue;
    const double b1 = pair.b1 / double(pair.weight);
    const double b2 = pair.b2 / double(pair.weight);
    if (!(b1 >= -kPositionSlack && b2 >= -kPositionSlack && b1 + b2 <= 1 + kPositionSlack)) {
      return absl::StrCat("position ", b1, " ", b2, where);
    }
  }
  const std::vector<uint64_t> covered = result.Covered(input.rect.Area());
  for (int64_t pixel = 0; pixel < input.rect.Area(); ++pixel) {
    if (covered[size_t(pixel)] > result.total) {
      return absl::StrCat("weight ", covered[size_t(pixel)], " of ", result.total, At(input.rect, pixel));
    }
    if (result.film.empty()) continue;
    const auto& film = result.film[size_t(pixel)];
    const double all = film[3] + double(covered[size_t(pixel)]);
    if (!(film[3] >= 0 && all <= double(result.total))) {
      return absl::StrCat("film's coverage ", film[3], " and ", all, At(input.rect, pixel));
    }
    const double slack = 1e-6 * double(result.total);
    for (size_t c = 0; c < 3; ++c) {
      if (!(film[c] >= -slack && film[c] <= film[3] + slack)) {
        return absl::StrCat("film's colour ", film[c], " of ", film[3], At(input.rect, pixel));
      }
    }
  }
  return "";
}

std::string BrokenFor(const Resolver& resolver, const HostileFrame& input, uint64_t seed,
                      const Resolver& used, bool has_film) {
  std::vector<uint32_t> candidates = AllOf(*input.frame);
  const Result pairs = Resolve(resolver, input, false, candidates);
  std::string broken = Broken(pairs, input, true);
  if (!broken.empty()) return broken;
  if (Resolve(used, input, false, candidates).pairs != pairs.pairs) return "what was resolved before shows";
  std::mt19937_64 random(seed);
  std::shuffle(candidates.begin(), candidates.end(), random);
  if (Resolve(used, input, false, candidates).pairs != pairs.pairs) return "the candidates' order shows";
  if (!has_film) return "";
  const Result film = Resolve(used, input, true, candidates);
  broken = Broken(film, input, true);
  if (!broken.empty()) return broken;
  const std::vector<uint64_t> expected = pairs.Covered(input.rect.Area());
  const std::vector<uint64_t> apart = film.Covered(input.rect.Area());
  for (int64_t pixel = 0; pixel < input.rect.Area(); ++pixel) {
    const double all = film.film[size_t(pixel)][3] + double(apart[size_t(pixel)]);
    if (all != double(expected[size_t(pixel)])) {
      return absl::StrCat("film and pairs cover ", all, ", pairs alone ", expected[size_t(pixel)],
                          At(input.rect, pixel));
    }
  }
  return "";
}

/// A resolver of each kind that stays for good, so that memory which it keeps meets every input.
const Resolver& Used(const RenderSettings& settings) {
  static std::map<std::tuple<ResolverKind, PatternKind, int>, std::unique_ptr<const Resolver>> used;
  auto& resolver = used[{settings.resolver, settings.pattern, settings.time_samples.value_or(0)}];
  if (resolver == nullptr) resolver = MakeResolver(settings);
  return *resolver;
}

std::string BrokenSegment(const LineSegment& segment, const SegmentPosition& position,
                          const SegmentLine& line) {
  if (!(line.begin <= segment.begin && segment.begin < segment.end && segment.end <= line.end)) return "ends";
  if (!(segment.l0 < segment.l1)) return "order of ends";
  if (!(segment.d0 >= 0 && segment.d0 <= 1 + 1e-9 && segment.d1 >= 0 && segment.d1 <= 1 + 1e-9)) {
    return absl::StrCat("depths ", segment.d0, " ", segment.d1);
  }
  if (!std::isfinite(segment.slope)) return "slope";
  for (const double s : {0.0, 0.5, 1.0}) {
    const double l = (segment.begin + s * (double(segment.end) - segment.begin)) / kSubpixelsPerPixel;
    const SegmentBarycentric at = BarycentricAt(segment, position, l);
    if (!(at.b1 >= -kPositionSlack && at.b2 >= -kPositionSlack && at.b1 + at.b2 <= 1 + kPositionSlack)) {
      return absl::StrCat("position ", at.b1, " ", at.b2);
    }
  }
  return "";
}

}  // namespace

std::string BrokenResolution(const HostileFrame& input, const RenderSettings& settings, uint64_t seed) {
  std::string broken = BrokenFor(*MakeResolver(settings), input, seed, Used(settings),
                                 settings.resolver == ResolverKind::kSlice);
  if (!broken.empty()) return absl::StrCat(std::string(ToString(settings.resolver)), ": ", broken);
  return "";
}

std::string BrokenTargets(const HostileFrame& input, const RenderSettings& settings) {
  const Resolver& resolver = Used(settings);
  const std::vector<uint32_t> candidates = AllOf(*input.frame);
  const Result best = Resolve(resolver, input, true, candidates);
  std::string broken;
  ForEachTarget([&] {
    if (Resolve(resolver, input, true, candidates) != best) broken = absl::StrCat("bits of ", KernelTarget());
  });
  return broken;
}

std::string BrokenAgreement(const HostileFrame& input, const RenderSettings& settings) {
  const std::vector<uint32_t> candidates = AllOf(*input.frame);
  const Result fast = Resolve(Used(settings), input, false, candidates);
  const Result plain = Resolve(ScalarResolver(settings), input, false, candidates);
  for (const auto& [a, b] : {std::pair{&fast, &plain}, std::pair{&plain, &fast}}) {
    for (const auto& [key, pair] : a->pairs) {
      const auto found = b->pairs.find(key);
      const double here = double(pair.weight) / double(a->total);
      const double there = found == b->pairs.end() ? 0 : double(found->second.weight) / double(b->total);
      if (std::abs(here - there) > kEndsSlack) {
        return absl::StrCat("triangle ", std::get<1>(key), " covers ", a == &fast ? here : there,
                            ", plainly ", a == &fast ? there : here, At(input.rect, std::get<0>(key)));
      }
    }
  }
  return "";
}

std::string BrokenCurtain(const HostileFrame& input, const RenderSettings& settings) {
  const Result result = Resolve(Used(settings), input, false, AllOf(*input.frame));
  const std::vector<uint64_t> covered = result.Covered(input.rect.Area());
  for (int64_t pixel = 0; pixel < input.rect.Area(); ++pixel) {
    if (covered[size_t(pixel)] != result.total) {
      return absl::StrCat(std::string(ToString(settings.resolver)), ": covered ", covered[size_t(pixel)],
                          " of ", result.total, At(input.rect, pixel));
    }
  }
  return "";
}

std::string BrokenSegments(const HostileFrame& input, const RenderSettings& settings) {
  const LinePattern& pattern = LinePattern::Get(settings.pattern);
  TileTriangles tile;
  SetUpTile(*input.frame, TraitsOf(*input.frame, true), pattern, input.rect, AllOf(*input.frame), tile);
  for (const TileLine& line : pattern.LinesIn(input.rect)) {
    const SegmentLine segment_line = MakeSegmentLine(pattern, line);
    for (uint32_t i = 0; i < tile.triangles.size(); ++i) {
      for (const double t : {0.0, 0.3, line.instant_offset, 1.0}) {
        LineSegment segment;
        SegmentPosition position;
        if (!MakeSegment(tile.triangles[i], i, tile.far_depth, segment_line, t, &segment, &position))
          continue;
        const std::string broken = BrokenSegment(segment, position, segment_line);
        if (!broken.empty()) {
          return absl::StrCat("segment of triangle ", segment.id, " on line ", line.number, " of family ",
                              line.family, " at ", t, ": ", broken);
        }
      }
    }
  }
  return "";
}

}  // namespace shutterline::engine
