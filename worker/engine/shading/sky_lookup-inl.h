// What a SkyMap sends towards many points. Included once per instruction set, by shade_kernels.cpp.
#if defined(SHUTTERLINE_SKY_LOOKUP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_SKY_LOOKUP_INL_H
#undef SHUTTERLINE_SKY_LOOKUP_INL_H
#else
#define SHUTTERLINE_SKY_LOOKUP_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "worker/engine/shading/shade_vectors-inl.h"
#include "worker/engine/shading/sky_map.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// QuickAngle.
HWY_INLINE Doubles Angle(Doubles y, Doubles x) {
  const Doubles zero = hn::Zero(ShadeTag());
  const Doubles across = hn::Abs(x), up = hn::Abs(y);
  const Doubles low = Lesser(across, up), high = Greater(across, up);
  const DoublesMask turned = hn::Gt(low, hn::Mul(All(0.41421356237309503), high));
  const Doubles tangent = hn::Div(hn::IfThenElse(turned, hn::Sub(low, high), low),
                                  hn::IfThenElse(turned, hn::Add(low, high), high));
  const Doubles s = hn::Mul(tangent, tangent), s2 = hn::Mul(s, s);
  const auto pair = [&](double constant, double factor) {
    return hn::Sub(All(constant), hn::Mul(All(factor), s));
  };
  const Doubles later = hn::Add(pair(0.1999818304113337, 0.14239532670301167),
                                hn::Mul(s2, pair(0.10569828810438991, 0.06026305236996569)));
  const Doubles series = hn::Add(pair(0.9999999993712282, 0.33333306893050235), hn::Mul(s2, later));
  Doubles angle = hn::Add(hn::Mul(tangent, series), hn::IfThenElseZero(turned, All(M_PI / 4)));
  angle = hn::IfThenElse(hn::Gt(up, across), hn::Sub(All(M_PI / 2), angle), angle);
  angle = hn::IfThenElse(hn::Lt(x, zero), hn::Sub(All(M_PI), angle), angle);
  angle = hn::IfThenElse(hn::Lt(y, zero), hn::Neg(angle), angle);
  return hn::IfThenElseZero(hn::Gt(high, zero), angle);
}

struct LatLongs {
  Doubles longitude, latitude;
};

/// LatLongOf.
HWY_INLINE LatLongs LatLongsOf(const Doubles3& v) {
  const Doubles longitude = hn::Div(Angle(v.x, hn::Neg(v.z)), All(2 * M_PI));
  const Doubles level = hn::Sqrt(hn::Add(hn::Mul(v.x, v.x), hn::Mul(v.z, v.z)));
  return {hn::IfThenElse(hn::Lt(longitude, hn::Zero(ShadeTag())), hn::Add(longitude, All(1)), longitude),
          hn::Div(Angle(level, v.y), All(M_PI))};
}

/// Maps of a sky, one a lane.
struct MapLanes {
  hn::Vec<ShadeInts> width, height, first;

  /// Of those with these numbers.
  MapLanes(const SkyMap& sky, const int32_t* numbers) {
    const ShadeInts di;
    HWY_ALIGN int32_t of[3][8];
    for (size_t i = 0; i < hn::Lanes(di); ++i) {
      const SkyMap::Map& map = sky.maps()[size_t(numbers[i])];
      of[0][i] = map.width;
      of[1][i] = map.height;
      of[2][i] = int32_t(map.first);
    }
    width = hn::Load(di, of[0]);
    height = hn::Load(di, of[1]);
    first = hn::Load(di, of[2]);
  }
};

/// SampleLatLong.
HWY_INLINE Doubles3 SampleMaps(const SkyMap& sky, const MapLanes& maps, const LatLongs& at) {
  const ShadeTag d;
  const ShadeFloats df;
  const ShadeInts di;
  const Doubles width = hn::PromoteTo(d, maps.width), height = hn::PromoteTo(d, maps.height);
  const Doubles x = hn::Add(hn::Mul(at.longitude, width), hn::Sub(width, All(0.5))),
                y = hn::Add(hn::Mul(at.latitude, height), All(0.5));
  const auto zero = hn::Zero(di), one = hn::Set(di, 1);
  // Whatever a lane of no point holds stays within the map.
  const auto within = [&](auto number, auto count) {
    return hn::Max(hn::Min(number, hn::Sub(count, one)), zero);
  };
  const auto column = hn::DemoteTo(di, x), row = hn::DemoteTo(di, y);
  const auto fx = hn::DemoteTo(df, hn::Sub(x, hn::PromoteTo(d, column)));
  const auto fy = hn::DemoteTo(df, hn::Sub(y, hn::PromoteTo(d, row)));
  const auto once = [&](auto number) {
    return hn::IfThenElse(hn::Lt(number, maps.width), number, hn::Sub(number, maps.width));
  };
  const auto x0 = within(once(once(column)), maps.width);
  const auto next = hn::Add(x0, one);
  const auto x1 = hn::IfThenElse(hn::Lt(next, maps.width), next, zero);
  const auto y0 = within(hn::Sub(row, one), maps.height), y1 = within(row, maps.height);
  const auto upper = hn::Add(maps.first, hn::Mul(y0, maps.width));
  const auto lower = hn::Add(maps.first, hn::Mul(y1, maps.width));
  const auto offset = [&](auto texel) { return hn::Add(texel, hn::Add(texel, texel)); };
  const auto upper_left = offset(hn::Add(upper, x0)), upper_right = offset(hn::Add(upper, x1));
  const auto lower_left = offset(hn::Add(lower, x0)), lower_right = offset(hn::Add(lower, x1));
  const auto channel = [&](size_t c) {
    const float* const texels = &sky.texels().data()->x + c;
    const auto of = [&](auto texel) { return hn::GatherIndex(df, texels, texel); };
    const auto mixed = Between(Between(of(upper_left), of(upper_right), fx),
                               Between(of(lower_left), of(lower_right), fx), fy);
    return hn::PromoteTo(d, mixed);
  };
  return {channel(0), channel(1), channel(2)};
}

/// SkyMap::Glossy.
HWY_INLINE Doubles3 Glossy(const SkyMap& sky, const Doubles3& direction, Doubles roughness) {
  if (sky.is_uniform()) return All(sky.uniform());
  const ShadeTag d;
  const ShadeInts di;
  const auto maps = sky.maps();
  Doubles number = hn::Zero(d), sharp = All(maps[0].roughness), rough = All(maps[1].roughness);
  for (size_t i = 1; i + 1 < maps.size(); ++i) {
    const DoublesMask is_rougher = hn::Lt(All(maps[i].roughness), roughness);
    number = hn::Add(number, hn::IfThenElseZero(is_rougher, All(1)));
    sharp = hn::IfThenElse(is_rougher, All(maps[i].roughness), sharp);
    rough = hn::IfThenElse(is_rougher, All(maps[i + 1].roughness), rough);
  }
  HWY_ALIGN int32_t numbers[8];
  hn::Store(hn::DemoteTo(di, number), di, numbers);
  const Doubles part =
      Clamped(hn::Div(hn::Sub(roughness, sharp), hn::Sub(rough, sharp)), hn::Zero(d), All(1));
  const LatLongs at = LatLongsOf(direction);
  const Doubles3 sharper = SampleMaps(sky, MapLanes(sky, numbers), at);
  for (size_t i = 0; i < hn::Lanes(di); ++i) ++numbers[i];
  const Doubles3 rougher = SampleMaps(sky, MapLanes(sky, numbers), at);
  const DoublesMask is_sharp = hn::Eq(part, hn::Zero(d));
  return Choose(is_sharp, sharper, sharper + Times(part, rougher - sharper));
}

/// SkyMap::Diffuse.
HWY_INLINE Doubles3 Diffuse(const SkyMap& sky, const Doubles3& n) {
  if (sky.is_uniform()) return All(sky.uniform());
  const auto& k = SkyMap::kHarmonics;
  const auto times = [](double factor, Doubles a) { return hn::Mul(All(factor), a); };
  const Doubles basis[] = {All(k[0]),
                           times(k[1], n.y),
                           times(k[1], n.z),
                           times(k[1], n.x),
                           hn::Mul(times(k[2], n.x), n.y),
                           hn::Mul(times(k[2], n.y), n.z),
                           times(k[3], hn::Sub(hn::Mul(times(3, n.z), n.z), All(1))),
                           hn::Mul(times(k[2], n.x), n.z),
                           times(k[4], hn::Sub(hn::Mul(n.x, n.x), hn::Mul(n.y, n.y)))};
  const Doubles zero = hn::Zero(ShadeTag());
  Doubles3 sum{zero, zero, zero};
  for (size_t i = 0; i < 9; ++i) sum = sum + Times(basis[i], All(sky.harmonics()[i]));
  return {Greater(sum.x, zero), Greater(sum.y, zero), Greater(sum.z, zero)};
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
