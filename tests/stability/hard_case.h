#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/math/spaces.h"
#include "tests/support/frame_scene_builder.h"
#include "tests/support/resolved_tile.h"

/// Hard cases are written for the pixel [0, 1]² of raster space, w = 1 unless they are about perspective,
/// and depth d in (0, 1], larger is nearer. A case can be replayed under the changes that must not
/// matter: moved to another pixel, mirrored, with x and y exchanged, with time reversed.
namespace shutterline::engine::hard_case {

struct MovingTriangle {
  std::array<RasterPoint, 3> open, close;
};

struct Case {
  std::vector<MovingTriangle> triangles;  ///< Their index is their id.
  bool double_sided = true;
};

/// A change under which the answer stays the same.
struct Variant {
  int dx = 0, dy = 0;  ///< Whole pixels.
  bool mirror = false;
  bool swap = false;
  bool reverse = false;

  std::string Name() const;
};

/// All combinations of mirror, swap and reverse, some of them moved.
std::vector<Variant> AllVariants();
/// Moved and time-reversed only: for patterns that are not symmetric (rgls).
std::vector<Variant> VariantsThatKeepLines();

RasterPoint At(double x, double y, double depth = 0.5);
/// A quad from corners in order, as two triangles, moving from `open` to `close`.
void AddQuad(Case& c, const std::array<RasterPoint, 4>& open, const std::array<RasterPoint, 4>& close);
/// The rectangle [x0, x1] × [y0, y1] that slides by (vx, vy).
void AddRectangle(Case& c, double x0, double y0, double x1, double y1, double vx, double vy,
                  double depth = 0.5);

/// Row 1: a rectangle from x0, `a` wide and higher than any pixel, that slides by v; and what of the pixel it
/// covers over the shutter.
Case Sliding(double x0, double a, double v);
double SlidingRectangle(double x0, double a, double v);

/// The case under a variant, with a tile of room around the pixel. Triangle i has the colour colors[i], or
/// white where there are none.
std::shared_ptr<const FrameScene> FrameOf(const Case& c, const Variant& variant, const FrameView& view,
                                          const std::vector<V3f>& colors = {});

/// Coverage of the pixel, per triangle and in sum.
struct Answer {
  std::vector<double> coverage;
  double sum = 0;
  double background = 0;
};
Answer Resolve(const Case& c, PatternKind pattern, int instants, const Variant& variant = {});
/// The same with the settings' pattern, resolver and what it takes.
Answer Resolve(const Case& c, const RenderSettings& settings, const Variant& variant = {});

/// Settings of a resolver with `instants` instants, or for those that have none, some number of time cells.
RenderSettings SettingsOf(ResolverKind resolver, PatternKind pattern, int instants);

/// A suite whose cases run for each resolver.
class EachResolver : public testing::TestWithParam<ResolverKind> {
 protected:
  static RenderSettings With(PatternKind pattern, int instants) {
    return SettingsOf(GetParam(), pattern, instants);
  }
  static Answer See(const Case& c, PatternKind pattern, int instants, const Variant& variant = {}) {
    return Resolve(c, With(pattern, instants), variant);
  }
};
inline std::string ResolverName(const testing::TestParamInfo<ResolverKind>& info) {
  return std::string(ToString(info.param));
}

/// Coverage of the stretch [0, 1] of the line y = height, summed over all triangles and without hiding,
/// by `instants` instants in the middle of their strata.
double LineCoverage(const Case& c, double height, int instants, double offset = 0.5);

/// Slope of log2(error) against log2(n), fitted by least squares.
double FittedSlope(const std::vector<int>& n, const std::vector<double>& error);

}  // namespace shutterline::engine::hard_case
