#include "tests/fuzz/hostile_segments.h"

#include <algorithm>
#include <cmath>

namespace shutterline::engine {
namespace {

int32_t Place(HostileValues& values, int32_t length, const std::vector<HostileSegment>& others) {
  int64_t x = 0;
  switch (values.Int(0, 5)) {
    case 0:
      x = values.Int(-1, 3);
      break;
    case 1:
      x = length - values.Int(-1, 3);
      break;
    case 2:
      x = int64_t{values.Int(0, 64)} << 24;
      break;
    case 3:
    case 4:
      if (!others.empty()) {
        const HostileSegment& other = others[values.Index(others.size())];
        x = int64_t{values.Chance(0.5) ? other.begin : other.end} + values.Int(-2, 2);
        break;
      }
      [[fallthrough]];
    default:
      x = int64_t(values.Unit() * length);
  }
  return int32_t(std::clamp<int64_t>(x, 0, length));
}

double Depth(HostileValues& values, const std::vector<HostileSegment>& others) {
  switch (values.Int(0, 5)) {
    case 0:
      return values.Int(0, 4) / 4.0;
    case 1:
    case 2:
      if (!others.empty()) {
        const double depth = double(others[values.Index(others.size())].depth);
        return std::clamp(depth + values.Int(-1, 1) * 0x1p-24, 0.0, 1.0);
      }
      [[fallthrough]];
    case 3:
      return std::ldexp(values.Unit(), values.Int(-149, 0));
    default:
      return values.Unit();
  }
}

}  // namespace

std::vector<HostileSegment> MakeHostileSegments(HostileValues& values, int32_t length, int count) {
  std::vector<HostileSegment> segments;
  const bool tiny = values.Chance(0.3);  // All within a few subpixels.
  const int32_t around = int32_t(values.Unit() * (length - 64));
  for (int i = 0; i < count; ++i) {
    HostileSegment s;
    if (!segments.empty() && values.Chance(0.15)) {
      s = segments[values.Index(segments.size())];
      if (values.Chance(0.5)) s.slope = std::nextafter(s.slope, values.Chance(0.5) ? 1.0f : -1.0f);
    } else {
      s.begin = Place(values, length, segments);
      s.end =
          values.Chance(0.2) ? std::min(length, s.begin + values.Int(0, 3)) : Place(values, length, segments);
      if (tiny) {
        s.begin = around + values.Int(0, 40);
        s.end = around + values.Int(0, 40);
      }
      if (s.begin > s.end) std::swap(s.begin, s.end);
      const double from = Depth(values, segments);
      const double to = values.Chance(0.3) ? from : Depth(values, segments);
      s.depth = float(from);
      s.slope = float((to - from) / std::max(1, s.end - s.begin));
    }
    segments.push_back(s);
  }
  std::vector<uint32_t> ids(segments.size());
  for (uint32_t i = 0; i < ids.size(); ++i) ids[i] = i;
  std::shuffle(ids.begin(), ids.end(), values.random());
  for (size_t i = 0; i < ids.size(); ++i) segments[i].id = ids[i];
  return segments;
}

}  // namespace shutterline::engine
