#include "worker/engine/slice/line_class.h"

#include <algorithm>
#include <cmath>

#include "common/math/tolerance.h"

namespace shutterline::engine {
namespace {

/// Do the lines of both rectangles lie alike relative to their corners? From one corner to the other a
/// family's lines must have moved on by whole pixels; then lines have moved on within their classes.
bool HaveSameLines(const LinePattern& pattern, const TileRect& a, const TileRect& b) {
  if (a.width != b.width || a.height != b.height) return false;
  for (const LineFamily& family : pattern.families()) {
    const double x = double(a.x) - double(b.x);
    const double y = double(a.y) - double(b.y);
    const double shift = family.major_is_x ? family.slope * x - y : family.slope * y - x;
    if (shift != std::floor(shift)) return false;
  }
  return true;
}

LineClass MakeClass(const LinePattern& pattern, const TileRect& rect, std::vector<TileLine> lines) {
  const TileLine& first = lines.front();
  const LineFamily& family = pattern.families()[size_t(first.family)];
  LineClass c{.family = first.family,
              .axes = {.major_is_x = family.major_is_x, .slope = family.slope, .intercept = first.intercept},
              .instant_offset = first.instant_offset,
              .lines_per_pixel = int(std::lround(1 / family.spacing)),
              .length = family.major_is_x ? rect.width : rect.height,
              .lines = std::move(lines)};
  c.pixels.resize(size_t(c.rows()) * size_t(c.length));
  for (int row = 0; row < c.rows(); ++row) {
    const TileLine& line = c.lines[size_t(row)];
    if (row % kLanes == 0) c.groups.emplace_back().first_row = row;
    LineGroup& group = c.groups.back();
    group.begin[size_t(group.lanes)] = line.first_step * kSubpixelsPerPixel;
    group.end[size_t(group.lanes)] = line.end_step * kSubpixelsPerPixel;
    ++group.lanes;
    for (int step = line.first_step; step < line.end_step; ++step) {
      const int minor = pattern.MinorPixel(line, step);
      c.pixels[size_t(row) * size_t(c.length) + size_t(step)] =
          c.axes.major_is_x ? minor * rect.width + step : step * rect.width + minor;
    }
  }
  return c;
}

}  // namespace

const std::vector<LineClass>& TileLines::In(const LinePattern& pattern, const TileRect& rect) {
  if (pattern_ == &pattern && HaveSameLines(pattern, rect, rect_)) return classes_;
  pattern_ = &pattern;
  rect_ = rect;
  classes_.clear();
  const std::vector<TileLine> lines = pattern.LinesIn(rect);
  for (size_t begin = 0; begin < lines.size();) {
    const int family = lines[begin].family;
    size_t end = begin;
    while (end < lines.size() && lines[end].family == family) ++end;
    // Lines of a pixel are `classes` apart in number; those of a class lie one pixel apart.
    const auto classes = size_t(std::lround(1 / pattern.families()[size_t(family)].spacing));
    for (size_t first = begin; first < std::min(begin + classes, end); ++first) {
      std::vector<TileLine> of_class;
      for (size_t i = first; i < end; i += classes) of_class.push_back(lines[i]);
      classes_.push_back(MakeClass(pattern, rect, std::move(of_class)));
    }
    begin = end;
  }
  return classes_;
}

}  // namespace shutterline::engine
