#include "worker/engine/slice/line_group.h"

#include <cmath>

#include "common/math/tolerance.h"

namespace shutterline::engine {

void GroupLines(const LinePattern& pattern, const TileRect& rect, std::vector<LineGroup>& groups) {
  groups.clear();
  const std::vector<TileLine> lines = pattern.LinesIn(rect);
  for (size_t begin = 0; begin < lines.size();) {
    const int family = lines[begin].family;
    size_t end = begin;
    while (end < lines.size() && lines[end].family == family) ++end;

    // Lines of a pixel are `classes` apart in number; those of a class lie one pixel apart.
    const LineFamily& source = pattern.families()[family];
    const auto classes = size_t(std::lround(1 / source.spacing));
    for (size_t c = begin; c < begin + classes && c < end; ++c) {
      for (size_t first = c; first < end; first += classes * kLanes) {
        LineGroup group{.family = family,
                        .major_is_x = source.major_is_x,
                        .slope = source.slope,
                        .intercept = lines[first].intercept,
                        .instant_offset = lines[first].instant_offset};
        for (size_t i = first; i < end && group.lanes < kLanes; i += classes) {
          group.lines[group.lanes] = lines[i];
          group.begin[group.lanes] = lines[i].first_step * kSubpixelsPerPixel;
          group.end[group.lanes] = lines[i].end_step * kSubpixelsPerPixel;
          ++group.lanes;
        }
        groups.push_back(group);
      }
    }
    begin = end;
  }
}

}  // namespace shutterline::engine
