#include "tests/fuzz/hostile_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/tolerance.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {
namespace {

double Cut(double x) {
  return std::clamp(x, -kMaxCoordinate, kMaxCoordinate);
}

}  // namespace

double HostileValues::AnyMagnitude() {
  // 2^146 is just below kMaxCoordinate.
  const double size = std::ldexp(1 + Unit(), Int(-1074, 145));
  return Chance(0.5) ? size : -size;
}

double HostileValues::FreshPosition(int side) {
  const double whole = Int(-2, side + 2);
  switch (Int(0, 9)) {
    case 0:
    case 1:
    case 2:
      return -side / 4.0 + 1.5 * side * Unit();
    case 3:
      return whole;
    case 4:
      return whole + Int(0, 7) / 8.0;
    case 5:  // On a border of subpixels, or in the middle between two.
      return whole + Int(-3, 3) * (0.5 / kSubpixelsPerPixel);
    case 6:
      return std::nextafter(whole + 0.5 * Int(0, 1), Chance(0.5) ? 1e300 : -1e300);
    case 7:
      return Chance(0.5) ? 0.0 : -0.0;
    case 8:
      return (Chance(0.5) ? 1 : -1) * std::exp2(30 * Unit());
    default:
      return AnyMagnitude();
  }
}

double HostileValues::Position(int side) {
  double value = 0;
  const double earlier = last_[Index(4)];
  switch (Int(0, 7)) {
    case 0:
      value = earlier;
      break;
    case 1:
      value = std::nextafter(earlier, Chance(0.5) ? 1e300 : -1e300);
      break;
    case 2:
      value = Chance(0.5) ? -earlier : earlier + 1e-7 * (Unit() - 0.5);
      break;
    default:
      value = FreshPosition(side);
  }
  value = Cut(value);
  last_[count_++ % 4] = value;
  return value;
}

double HostileValues::W(double near) {
  switch (Int(0, 9)) {
    case 0:
      return near;
    case 1:
      return std::nextafter(near, Chance(0.5) ? 1e300 : -1e300);
    case 2:
      return Chance(0.5) ? 0.0 : -near;
    case 3:
      return AnyMagnitude();
    case 4:
      return -Unit();
    case 5:
      return near * std::exp2(4 * Unit() - 2);
    default:
      return WInFront(near);
  }
}

double HostileValues::WInFront(double near) {
  double w = 0;
  switch (Int(0, 5)) {
    case 0:
      w = near;
      break;
    case 1:
      w = std::abs(AnyMagnitude());
      break;
    case 2:
      w = 1;
      break;
    default:
      w = std::exp2(8 * Unit() - 4);
  }
  return Cut(std::max({w, near, 0x1p-100}));
}

}  // namespace shutterline::engine
