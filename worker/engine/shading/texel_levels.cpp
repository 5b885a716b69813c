#include "worker/engine/shading/texel_levels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace shutterline::engine {
namespace {

/// The least level whose texels are at most √2 / rate pixels wide, `squared` being the square of a pixel's
/// part of the triangle's side times the rate: the least with 2^(2 level) · 2 squared >= 1, from the
/// exponent's bits.
int LevelFor(double squared) {
  const auto exponent = int(std::bit_cast<uint64_t>(2 * squared) >> 52) - 1023;
  return std::max((1 - exponent) >> 1, 0);
}

}  // namespace

TexelLevelsOfTriangle::TexelLevelsOfTriangle(const std::array<RasterPoint, 3>& corners, double rate)
    : w0_(corners[0].w), w1_(corners[1].w - corners[0].w), w2_(corners[2].w - corners[0].w) {
  const V3d p0(corners[0].x, corners[0].y, corners[0].w);
  const V3d p1(corners[1].x, corners[1].y, corners[1].w);
  const V3d p2(corners[2].x, corners[2].y, corners[2].w);
  const double over = 1 / (p0.dot(p1.cross(p2)) * rate);
  const V3d r0 = over * p1.cross(p2), r1 = over * p2.cross(p0), r2 = over * p0.cross(p1);
  const V3d sum = r0 + r1 + r2;
  const auto is_finite = [](const V3d& v) { return std::isfinite(v.x) && std::isfinite(v.y); };
  if (!is_finite(r1) || !is_finite(r2) || !is_finite(sum)) return;
  rise1_ = {r1.x, r1.y};
  rise2_ = {r2.x, r2.y};
  rise_sum_ = {sum.x, sum.y};

  const std::optional<TexelLevels> middle = LevelsOf({1.0 / 3, 1.0 / 3});
  if (!middle) return;
  for (const Barycentric& corner : {Barycentric{0, 0}, Barycentric{1, 0}, Barycentric{0, 1}}) {
    if (LevelsOf(corner) != middle) return;
  }
  uniform_ = *middle;
  columns_ = double(uint64_t{1} << middle->level1);
  rows_ = double(uint64_t{1} << middle->level2);
  is_uniform_ = true;
}

std::optional<TexelLevels> TexelLevelsOfTriangle::LevelsOf(const Barycentric& at) const {
  const double w = w0_ + at.b1 * w1_ + at.b2 * w2_;
  const V2d along1 = w * (rise1_ - at.b1 * rise_sum_), along2 = w * (rise2_ - at.b2 * rise_sum_);
  const double squared1 = along1.length2(), squared2 = along2.length2();
  // The exponents of what is below are those of no level.
  if (!(w > 0 && squared1 >= kLeastTexelRise && squared2 >= kLeastTexelRise && squared1 < HUGE_VAL &&
        squared2 < HUGE_VAL)) {
    return std::nullopt;
  }
  const TexelLevels levels{LevelFor(squared1), LevelFor(squared2)};
  if (levels.level1 + levels.level2 > Texel::kMaxLevelSum) return std::nullopt;
  return levels;
}

}  // namespace shutterline::engine
