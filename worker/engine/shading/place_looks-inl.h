// Where the walks of a batch look at levels of an image. Included once per instruction set, by
// shade_kernels.cpp.
#if defined(SHUTTERLINE_PLACE_LOOKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_PLACE_LOOKS_INL_H
#undef SHUTTERLINE_PLACE_LOOKS_INL_H
#else
#define SHUTTERLINE_PLACE_LOOKS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "worker/engine/shading/batch_looks.h"
#include "worker/engine/shading/shade_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A side of levels, one a lane. All numbers of texels are integers that a double holds exactly: coordinates
/// are reduced to 10^9 images.
class SideLanes {
 public:
  /// `whole`: of level 0.
  SideLanes(int whole, hn::Vec<ShadeInts> level, WrapMode mode) : mode_(mode) {
    const ShadeInts di;
    const ShadeTag d;
    size_ = hn::PromoteTo(d, hn::Max(hn::Shr(hn::Set(di, whole), level), hn::Set(di, 1)));
    period_ = mode == WrapMode::kMirroredRepeat ? hn::Add(size_, size_) : size_;
    of_period_ = hn::Div(All(1), period_);
  }

  Doubles size() const { return size_; }

  /// The texels that the numbers `at` and `at` + 1 mean.
  void Wrap(Doubles at, Doubles& texel, Doubles& next) const {
    const Doubles zero = hn::Zero(ShadeTag()), one = All(1);
    if (mode_ == WrapMode::kClampToEdge) {
      const Doubles last = hn::Sub(size_, one);
      texel = hn::Min(hn::Max(at, zero), last);
      next = hn::Min(hn::Max(hn::Add(at, one), zero), last);
      return;
    }
    // What is no multiple of a period is so far from one that the product's rounding does not matter.
    texel = hn::Sub(at, hn::Mul(period_, hn::Floor(hn::Mul(at, of_period_))));
    texel = hn::Sub(texel, hn::IfThenElseZero(hn::Ge(texel, period_), period_));
    next = hn::Add(texel, one);
    next = hn::IfThenElseZero(hn::Lt(next, period_), next);
    if (mode_ == WrapMode::kRepeat) return;
    const Doubles last = hn::Sub(period_, one);
    texel = hn::IfThenElse(hn::Lt(texel, size_), texel, hn::Sub(last, texel));
    next = hn::IfThenElse(hn::Lt(next, size_), next, hn::Sub(last, next));
  }

 private:
  WrapMode mode_;
  Doubles size_, period_, of_period_;
};

/// What lanes of points want of a level.
struct WalkLanes {
  Doubles u, v, step_u, step_v, first;
  DoublesMask has_one;      ///< Look: in the middle, where steps may be infinite.
  DoublesMask takes_whole;  ///< Of one texel, the nearest.
  int most = 1;             ///< Looks.

  WalkLanes(const WalkedImage& image, const SurfaceBatch& batch, size_t k)
      : u(At(batch.u, k)), v(At(batch.v, k)), step_u(At(batch.step_u, k)), step_v(At(batch.step_v, k)) {
    const ShadeTag d;
    const Doubles probes = hn::PromoteTo(d, hn::Load(ShadeInts(), batch.probes.data() + k));
    const Doubles one = All(1);
    has_one = hn::Le(probes, one);
    takes_whole = hn::Lt(probes, All(image.nearest ? 1 : 0));
    first = hn::Mul(All(-0.5), hn::Sub(probes, one));
    for (size_t i = 0; i < hn::Lanes(d); ++i) most = std::max(most, int(batch.probes[k + i]));
  }

  /// `k` is the first lane's point.
  void Place(const WalkedImage& image, hn::Vec<ShadeInts> level, size_t k, std::span<BatchLook> looks) const {
    const ShadeFloats df;
    const ShadeInts di;
    const SideLanes across(image.width, level, image.wrap_s), down(image.height, level, image.wrap_t);
    const Doubles most_images = All(1e9), half = hn::IfThenZeroElse(takes_whole, All(0.5));
    const auto put = [&](Doubles top, Doubles column, auto& to) {
      const Doubles number = hn::Add(hn::Mul(top, across.size()), column);
      hn::Store(hn::DemoteTo(di, number), di, to.data() + k);
    };
    for (int i = 0; i < most; ++i) {
      const Doubles at = hn::Add(first, All(i));
      const auto place = [&](const SideLanes& side, Doubles middle, Doubles step, Doubles& whole) {
        const Doubles along = hn::IfThenElse(has_one, middle, hn::Add(middle, hn::Mul(at, step)));
        const Doubles texels =
            hn::Sub(hn::Mul(Clamped(along, hn::Neg(most_images), most_images), side.size()), half);
        whole = hn::Floor(texels);
        return hn::IfThenZeroElse(takes_whole, hn::Sub(texels, whole));
      };
      Doubles x, y, left, right, top, bottom;
      const Doubles part_x = place(across, u, step_u, x), part_y = place(down, v, step_v, y);
      across.Wrap(x, left, right);
      down.Wrap(y, top, bottom);
      right = hn::IfThenElse(takes_whole, left, right);
      bottom = hn::IfThenElse(takes_whole, top, bottom);
      const auto n = size_t(i);
      put(top, left, looks[n].top_left);
      put(top, right, looks[n].top_right);
      put(bottom, left, looks[n].bottom_left);
      put(bottom, right, looks[n].bottom_right);
      hn::Store(hn::DemoteTo(df, part_x), df, looks[n].right.data() + k);
      hn::Store(hn::DemoteTo(df, part_y), df, looks[n].down.data() + k);
    }
  }
};

/// TextureWalk::Follow.
inline void PlaceLooksKernel(const WalkedImage& image, const SurfaceBatch& batch, BatchWalks& walks) {
  const ShadeTag d;
  const ShadeInts di;
  for (size_t k = 0; k < batch.count; k += hn::Lanes(d)) {
    const WalkLanes lanes(image, batch, k);
    const auto level = hn::Load(di, batch.level.data() + k);
    lanes.Place(image, level, k, walks.fine);
    const auto between = hn::Load(ShadeFloats(), batch.between.data() + k);
    if (hn::AllTrue(ShadeFloats(), hn::Le(between, hn::Zero(ShadeFloats())))) continue;
    lanes.Place(image, hn::Add(level, hn::Set(di, 1)), k, walks.coarse);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
