#include "worker/engine/shading/texture_sampler.h"

#include <algorithm>
#include <cmath>

namespace shutterline::engine {
namespace {

/// Where uv lies in texels of a level; huge coordinates are reduced so that they fit an integer.
double TexelCoordinate(double u, int size) {
  return std::clamp(u, -1e9, 1e9) * size;
}

/// Exact where both ends are equal, so that a constant image stays constant.
V3f Mix(const V3f& a, const V3f& b, float part) {
  return a + part * (b - a);
}

V3f Color(const MipPyramid& pyramid, int level, int x, int y) {
  const V4f texel = pyramid.Texel(level, x, y);
  return {texel.x, texel.y, texel.z};
}

V3f Nearest(const MipPyramid& pyramid, int level, const Texture& texture, const V2d& uv) {
  const int width = pyramid.Width(level), height = pyramid.Height(level);
  const auto x = int64_t(std::floor(TexelCoordinate(uv.x, width)));
  const auto y = int64_t(std::floor(TexelCoordinate(uv.y, height)));
  return Color(pyramid, level, WrapTexel(x, width, texture.wrap_s), WrapTexel(y, height, texture.wrap_t));
}

V3f Bilinear(const MipPyramid& pyramid, int level, const Texture& texture, const V2d& uv) {
  const int width = pyramid.Width(level), height = pyramid.Height(level);
  const double x = TexelCoordinate(uv.x, width) - 0.5, y = TexelCoordinate(uv.y, height) - 0.5;
  const auto x0 = int64_t(std::floor(x)), y0 = int64_t(std::floor(y));
  const auto fx = float(x - double(x0)), fy = float(y - double(y0));
  const int left = WrapTexel(x0, width, texture.wrap_s), right = WrapTexel(x0 + 1, width, texture.wrap_s);
  const int top = WrapTexel(y0, height, texture.wrap_t), bottom = WrapTexel(y0 + 1, height, texture.wrap_t);
  return Mix(Mix(Color(pyramid, level, left, top), Color(pyramid, level, right, top), fx),
             Mix(Color(pyramid, level, left, bottom), Color(pyramid, level, right, bottom), fx), fy);
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

V3f SampleTexture(const MipPyramid& pyramid, const Texture& texture, V2d uv, const V2d& duv_dx,
                  const V2d& duv_dy) {
  if (!std::isfinite(uv.x)) uv.x = 0;
  if (!std::isfinite(uv.y)) uv.y = 0;
  const double texels = std::max(TexelLength(pyramid, duv_dx), TexelLength(pyramid, duv_dy));
  if (!(texels > 1)) {
    return texture.nearest ? Nearest(pyramid, 0, texture, uv) : Bilinear(pyramid, 0, texture, uv);
  }
  const int last = pyramid.level_count() - 1;
  const double lod = std::min<double>(std::log2(texels), last);
  const int level = std::min(int(lod), last);
  const auto between = float(lod - level);
  const V3f fine = Bilinear(pyramid, level, texture, uv);
  if (between == 0) return fine;
  return Mix(fine, Bilinear(pyramid, level + 1, texture, uv), between);
}

}  // namespace shutterline::engine
