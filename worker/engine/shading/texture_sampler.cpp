#include "worker/engine/shading/texture_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace shutterline::engine {
namespace {

/// Where uv lies in texels of a level; huge coordinates are reduced so that they fit an integer.
double TexelCoordinate(double u, int size) {
  return std::clamp(u, -1e9, 1e9) * size;
}

/// Exact where both ends are equal, so that a constant image stays constant.
V4f Mix(const V4f& a, const V4f& b, float part) {
  return a + part * (b - a);
}

V4f Nearest(const MipPyramid& pyramid, int level, const Texture& texture, const V2d& uv) {
  const int width = pyramid.Width(level), height = pyramid.Height(level);
  const auto x = int64_t(std::floor(TexelCoordinate(uv.x, width)));
  const auto y = int64_t(std::floor(TexelCoordinate(uv.y, height)));
  return pyramid.Texel(level, WrapTexel(x, width, texture.wrap_s), WrapTexel(y, height, texture.wrap_t));
}

V4f Bilinear(const MipPyramid& pyramid, int level, const Texture& texture, const V2d& uv) {
  const int width = pyramid.Width(level), height = pyramid.Height(level);
  const double x = TexelCoordinate(uv.x, width) - 0.5, y = TexelCoordinate(uv.y, height) - 0.5;
  const auto x0 = int64_t(std::floor(x)), y0 = int64_t(std::floor(y));
  const auto fx = float(x - double(x0)), fy = float(y - double(y0));
  const int left = WrapTexel(x0, width, texture.wrap_s), right = WrapTexel(x0 + 1, width, texture.wrap_s);
  const int top = WrapTexel(y0, height, texture.wrap_t), bottom = WrapTexel(y0 + 1, height, texture.wrap_t);
  const std::array<V4f, 4> texels = pyramid.Texels(level, left, right, top, bottom);
  return Mix(Mix(texels[0], texels[1], fx), Mix(texels[2], texels[3], fx), fy);
}

/// Of a footprint of so many texels (of level 0, at least 1) in every direction.
V4f Trilinear(const MipPyramid& pyramid, const Texture& texture, const V2d& uv, double texels) {
  const int last = pyramid.level_count() - 1;
  const double lod = std::min<double>(std::log2(texels), last);
  const int level = std::min(int(lod), last);
  const auto between = float(lod - level);
  const V4f fine = Bilinear(pyramid, level, texture, uv);
  if (between == 0) return fine;
  return Mix(fine, Bilinear(pyramid, level + 1, texture, uv), between);
}

/// Length of a footprint axis in texels of level 0.
double TexelLength(const MipPyramid& pyramid, const V2d& duv) {
  return std::hypot(duv.x * pyramid.Width(0), duv.y * pyramid.Height(0));
}

}  // namespace

int WrapTexel(int64_t index, int size, WrapMode mode) {
  if (mode == WrapMode::kClampToEdge) return int(std::clamp<int64_t>(index, 0, size - 1));
  const int64_t period = mode == WrapMode::kMirroredRepeat ? 2 * int64_t{size} : size;
  int64_t i = index % period;
  if (i < 0) i += period;
  return int(i < size ? i : period - 1 - i);
}

V4f SampleTexture(const MipPyramid& pyramid, const Texture& texture, V2d uv, const V2d& duv_dx,
                  const V2d& duv_dy, int most_probes) {
  if (!std::isfinite(uv.x)) uv.x = 0;
  if (!std::isfinite(uv.y)) uv.y = 0;
  const double along_x = TexelLength(pyramid, duv_dx), along_y = TexelLength(pyramid, duv_dy);
  const double longest = std::max(along_x, along_y);
  if (!(longest > 1)) {
    return texture.nearest ? Nearest(pyramid, 0, texture, uv) : Bilinear(pyramid, 0, texture, uv);
  }
  if (!std::isfinite(along_x) || !std::isfinite(along_y)) return Trilinear(pyramid, texture, uv, longest);
  // The footprint is a parallelogram: so long, and across that side so wide.
  const double area =
      std::abs(duv_dx.x * duv_dy.y - duv_dx.y * duv_dy.x) * pyramid.Width(0) * pyramid.Height(0);
  const double width = std::max(area / longest, 1.0);
  const double ratio = std::ceil(longest / width - 1e-6);
  const int probes = ratio < most_probes ? std::max(int(ratio), 1) : most_probes;
  const double texels = std::max(longest / probes, 1.0);
  if (probes == 1) return Trilinear(pyramid, texture, uv, texels);
  const V2d& axis = along_x >= along_y ? duv_dx : duv_dy;
  V4f sum(0);
  for (int i = 0; i < probes; ++i) {
    sum += Trilinear(pyramid, texture, uv + ((i + 0.5) / probes - 0.5) * axis, texels);
  }
  return sum / float(probes);
}

}  // namespace shutterline::engine
