#include "worker/engine/shading/texture_walk.h"

#include <algorithm>
#include <cmath>

#include "worker/engine/shading/log2.h"

namespace shutterline::engine {
namespace {

/// std::floor of numbers that fit: a call, where processors need not have an instruction for it.
int64_t Floor(double x) {
  const auto cut = int64_t(x);
  return cut - int64_t(x < double(cut));
}

/// Huge coordinates are reduced so that texels' numbers fit an integer.
double Reduced(double u) {
  return std::clamp(u, -1e9, 1e9);
}

/// A side of a level.
class Side {
 public:
  Side(int size, WrapMode mode)
      : size_(size),
        scale_(size),
        repeats_(mode == WrapMode::kRepeat && (size & (size - 1)) == 0),
        mode_(mode) {}

  /// Where u, which has been reduced, lies in texels.
  double Place(double u) const { return u * scale_; }

  uint32_t Wrap(int64_t index) const {
    if (repeats_) return uint32_t(index) & uint32_t(size_ - 1);
    if (uint64_t(index) < uint64_t(size_)) return uint32_t(index);
    return uint32_t(WrapTexel(index, size_, mode_));
  }

 private:
  int size_;
  double scale_;  ///< The same, without a conversion a look.
  bool repeats_;  ///< And is a power of two.
  WrapMode mode_;
};

/// Makes looks at one level.
class LevelLooks {
 public:
  LevelLooks(const WalkedImage& image, int level)
      : width_(uint32_t(std::max(image.width >> level, 1))),
        across_(int(width_), image.wrap_s),
        down_(std::max(image.height >> level, 1), image.wrap_t) {}

  void Bilinear(const V2d& uv, TexelQuad& quad) const {
    const double x = across_.Place(Reduced(uv.x)) - 0.5, y = down_.Place(Reduced(uv.y)) - 0.5;
    const int64_t x0 = Floor(x), y0 = Floor(y);
    const uint32_t left = across_.Wrap(x0), right = across_.Wrap(x0 + 1);
    const uint32_t top = down_.Wrap(y0) * width_, bottom = down_.Wrap(y0 + 1) * width_;
    quad.top_left = top + left;
    quad.top_right = top + right;
    quad.bottom_left = bottom + left;
    quad.bottom_right = bottom + right;
    quad.right = float(x - double(x0));
    quad.down = float(y - double(y0));
  }

  void Nearest(const V2d& uv, TexelQuad& quad) const {
    const uint32_t x = across_.Wrap(Floor(across_.Place(Reduced(uv.x))));
    const uint32_t y = down_.Wrap(Floor(down_.Place(Reduced(uv.y))));
    quad.top_left = quad.top_right = quad.bottom_left = quad.bottom_right = y * width_ + x;
    quad.right = quad.down = 0;
  }

 private:
  uint32_t width_;
  Side across_, down_;
};

V4f Mix(const V4f& a, const V4f& b, float part) {
  return a + part * (b - a);
}

}  // namespace

int WrapTexel(int64_t index, int size, WrapMode mode) {
  if (mode == WrapMode::kClampToEdge) return int(std::clamp<int64_t>(index, 0, size - 1));
  const int64_t period = mode == WrapMode::kMirroredRepeat ? 2 * int64_t{size} : size;
  int64_t i = index % period;
  if (i < 0) i += period;
  return int(i < size ? i : period - 1 - i);
}

void TextureWalk::LookOnce(const WalkedImage& image, const V2d& uv) {
  probes_ = 1;
  level_ = 0;
  between_ = 0;
  const LevelLooks looks(image, 0);
  if (image.nearest) {
    looks.Nearest(uv, fine_[0]);
  } else {
    looks.Bilinear(uv, fine_[0]);
  }
}

WalkPlan WalkPlan::Make(const WalkedImage& image, V2d uv, const V2d& duv_dx, const V2d& duv_dy,
                        int most_probes) {
  if (!std::isfinite(uv.x)) uv.x = 0;
  if (!std::isfinite(uv.y)) uv.y = 0;
  WalkPlan plan;
  plan.uv = uv;
  // Measure the footprint's sides in texels. Squares that overflow are those of sides that cover the image
  // many times: its mean is seen all the same.
  const double width = image.width, height = image.height;
  const V2d side_x(duv_dx.x * width, duv_dx.y * height), side_y(duv_dy.x * width, duv_dy.y * height);
  const double square_x = side_x.dot(side_x), square_y = side_y.dot(side_y);
  const double square = std::max(square_x, square_y);
  if (!(square > 1)) return plan;

  // The footprint is a parallelogram: so long, and across that side so wide.
  plan.probes = 1;
  double texels_square = square;
  if (std::isfinite(square_x) && std::isfinite(square_y)) {
    const double longest = std::sqrt(square);
    const double area = std::abs(side_x.x * side_y.y - side_x.y * side_y.x);
    const double ratio = longest / std::max(area / longest, 1.0) - 1e-6;
    // The next integer.
    plan.probes =
        ratio < most_probes ? std::clamp(int(ratio) + int(ratio > int(ratio)), 1, most_probes) : most_probes;
    texels_square = std::max(square / (plan.probes * plan.probes), 1.0);
  }
  const double lod = std::min<double>(0.5 * Log2(texels_square), image.LastLevel());
  plan.level = int(lod);
  plan.between = float(lod - plan.level);
  // Look along the longer side.
  plan.step = (square_x >= square_y ? duv_dx : duv_dy) / plan.probes;
  return plan;
}

void TextureWalk::Follow(const WalkedImage& image, const WalkPlan& plan) {
  if (plan.probes == 0) return LookOnce(image, plan.uv);
  probes_ = plan.probes;
  level_ = plan.level;
  between_ = plan.between;
  const double first = -0.5 * (probes_ - 1);
  const auto look = [&](int level, std::array<TexelQuad, kMostProbes>& quads) {
    const LevelLooks looks(image, level);
    if (probes_ == 1) return looks.Bilinear(plan.uv, quads[0]);  // Where steps may be infinite.
    for (int i = 0; i < probes_; ++i) looks.Bilinear(plan.uv + (first + i) * plan.step, quads[size_t(i)]);
  };
  look(level_, fine_);
  if (between_ > 0) look(level_ + 1, coarse_);
}

void TextureWalk::Prefetch(const MipPyramid& pyramid) const {
  const auto looks = size_t(probes_);
  pyramid.Prefetch(level_, {fine_.data(), looks});
  if (between_ > 0) pyramid.Prefetch(level_ + 1, {coarse_.data(), looks});
}

V4f TextureWalk::Sample(const MipPyramid& pyramid) const {
  const auto looks = size_t(probes_);
  V4f sum = pyramid.Sum(level_, {fine_.data(), looks});
  if (between_ > 0) sum = Mix(sum, pyramid.Sum(level_ + 1, {coarse_.data(), looks}), between_);
  return probes_ == 1 ? sum : sum / float(probes_);
}

}  // namespace shutterline::engine
