#include "worker/engine/sampling/line_pattern.h"

#include <cmath>
#include <utility>

#include "common/base/check.h"

namespace shutterline::engine {
namespace {

std::vector<LineFamily> AxisAligned(int lines) {
  const double spacing = 1.0 / lines;
  return {{.major_is_x = true, .slope = 0, .offset = spacing / 2, .spacing = spacing},
          {.major_is_x = false, .slope = 0, .offset = spacing / 2, .spacing = spacing}};
}

std::vector<LineFamily> RotatedGrid() {
  return {{.major_is_x = true, .slope = 0.5, .offset = 0, .spacing = 0.5},
          {.major_is_x = false, .slope = -0.5, .offset = 0, .spacing = 0.5}};
}

}  // namespace

LinePattern::LinePattern(std::vector<LineFamily> families) : families_(std::move(families)) {
  for (const LineFamily& family : families_) steps_per_pixel_ += int(std::lround(1 / family.spacing));
}

const LinePattern& LinePattern::Get(PatternKind kind) {
  static const LinePattern k1h1v(AxisAligned(1));
  static const LinePattern k2h2v(AxisAligned(2));
  static const LinePattern k4h4v(AxisAligned(4));
  static const LinePattern k8h8v(AxisAligned(8));
  static const LinePattern k16h16v(AxisAligned(16));
  static const LinePattern kRgls(RotatedGrid());
  switch (kind) {
    case PatternKind::k1h1v:
      return k1h1v;
    case PatternKind::k2h2v:
      return k2h2v;
    case PatternKind::k4h4v:
      return k4h4v;
    case PatternKind::k8h8v:
      return k8h8v;
    case PatternKind::k16h16v:
      return k16h16v;
    case PatternKind::kAuto:
    case PatternKind::kRgls:
      return kRgls;
  }
  SL_CHECK(false);
  return kRgls;
}

int LinePattern::MinorPixel(const TileLine& line, int step) const {
  return int(std::floor(line.intercept + families_[line.family].slope * (step + 0.5)));
}

std::vector<TileLine> LinePattern::LinesIn(const TileRect& rect) const {
  std::vector<TileLine> lines;
  for (int f = 0; f < int(families_.size()); ++f) {
    const LineFamily& family = families_[f];
    const int length = family.major_is_x ? rect.width : rect.height;
    const int breadth = family.major_is_x ? rect.height : rect.width;
    const double major_corner = family.major_is_x ? rect.x : rect.y;
    const double minor_corner = family.major_is_x ? rect.y : rect.x;
    // Relative to the corner, line k has the intercept first + k * spacing.
    const double first = family.offset + family.slope * major_corner - minor_corner;
    // Over the rectangle's length a line climbs by at most this much: bounds for k, exact steps below.
    const double climb = std::abs(family.slope) * length;
    const auto k_begin = int64_t(std::floor((-climb - first) / family.spacing)) - 1;
    const auto k_end = int64_t(std::ceil((breadth + climb - first) / family.spacing)) + 1;
    for (int64_t k = k_begin; k <= k_end; ++k) {
      TileLine line{.family = f, .number = k, .intercept = first + double(k) * family.spacing};
      int step = 0;
      const auto inside = [&](int i) {
        const int minor = MinorPixel(line, i);
        return minor >= 0 && minor < breadth;
      };
      while (step < length && !inside(step)) ++step;
      line.first_step = step;
      while (step < length && inside(step)) ++step;
      line.end_step = step;
      if (line.first_step == line.end_step) continue;
      line.instant_offset = InstantOffset(family, f, k);
      lines.push_back(line);
    }
  }
  return lines;
}

double InstantOffset(const LineFamily& family, int family_index, int64_t number) {
  // The lines that meet in a pixel: number within the pixel first, then family.
  const auto lines_per_pixel = int64_t(std::lround(1 / family.spacing));
  const int64_t within = ((number % lines_per_pixel) + lines_per_pixel) % lines_per_pixel;
  auto index = uint64_t(within + lines_per_pixel * family_index);
  double offset = 0;
  double digit = 0.5;
  for (int64_t cells = 2 * lines_per_pixel; cells > 1; cells /= 2, digit /= 2, index >>= 1) {
    if ((index & 1) != 0) offset += digit;
  }
  return offset + digit;  // The centre of the cell of the last digit.
}

}  // namespace shutterline::engine
