#include "worker/engine/slice/effort_pilot.h"

#include <algorithm>
#include <cmath>

#include "common/math/tolerance.h"
#include "worker/engine/visibility/time_samples.h"

namespace shutterline::engine {
namespace {

/// Means are taken over the pixels in which anything differs, or a large surface at rest would hide a small
/// one that moves; over so many at least, an eighth of a tile, or a single pixel would decide for all.
constexpr int64_t kFewestChanging = 128;

}  // namespace

EffortPilot::Findings EffortPilot::Fly(TileStrata& strata, const std::vector<LineClass>& classes,
                                       int64_t instants, const ShutterCurve& shutter, TileColors& colors,
                                       ColorFilm& film, const AlphaSource* alpha, RenderStats& stats) {
  colors.BeginGuessing(strata.mesh(), film);
  const std::array<const LineClass*, 2> lines{&classes.front(), &classes.back()};
  const bool moves = instants > 1;
  for (size_t f = 0; f < 2; ++f) {
    const double offset = f == 0 ? 0.25 : 0.75;
    for (size_t half = 0; half < (moves ? 2u : 1u); ++half) {
      RenderPart(strata, *lines[f], instants, offset, half == 1, shutter, colors, film, alpha, stats,
                 parts_[f][half]);
    }
  }

  const double weight = double(instants) * double(kSubpixelsPerPixel);  // Of a family, or of a half.
  double time_sum = 0, space_sum = 0;
  int64_t changing = 0;
  for (size_t i = 0; i < parts_[0][0].size(); ++i) {
    double changes = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double a0 = parts_[0][0][i][c], b0 = moves ? parts_[0][1][i][c] : 0;
      const double a1 = parts_[1][0][i][c], b1 = moves ? parts_[1][1][i][c] : 0;
      const double in_time = moves ? ((a0 + a1) - (b0 + b1)) / weight : 0;
      const double in_space = ((a0 + b0) - (a1 + b1)) / weight;
      time_sum += in_time * in_time;
      // What lines miss at all times is in both halves; what they miss as things move is another in each.
      space_sum += moves ? 4 * (a0 - a1) * (b0 - b1) / (weight * weight) : in_space * in_space;
      changes += in_time * in_time + in_space * in_space;
    }
    if (changes > 0) ++changing;
  }
  const double values = 3 * double(std::max(changing, kFewestChanging));
  Findings findings{.samples = 2 * instants,
                    .time_difference = std::sqrt(time_sum / values),
                    .space_difference = std::sqrt(std::max(0.0, space_sum) / values)};
  for (uint32_t i = 0; i < strata.mesh().triangles().size(); ++i) {
    const TileMeshTriangle& triangle = strata.mesh().triangles()[i];
    if (triangle.shading_bins_log2 == 0 || !colors.WasSeen(i)) continue;
    if (colors.IsByPoints(i)) {
      findings.sees_moving_textures = true;
    } else {
      findings.textured_motion_pixels =
          std::max(findings.textured_motion_pixels, double(triangle.motion_pixels));
    }
  }
  return findings;
}

void EffortPilot::RenderPart(TileStrata& strata, const LineClass& lines, int64_t instants, double offset,
                             bool inner, const ShutterCurve& shutter, TileColors& colors, ColorFilm& film,
                             const AlphaSource* alpha, RenderStats& stats, Sums& sums) {
  instants_.clear();
  for (int64_t i = 0; i < instants; ++i) {
    const bool is_inner = i % 4 == 1 || i % 4 == 2;
    if (is_inner != inner) continue;
    instants_.push_back(shutter.TimeOf(TimeSamples::InstantAt(i, instants, offset)));
  }
  film.Reset(strata.mesh().rect().Area());
  const int64_t lines_before = stats.lines;
  resolver_.Resolve(strata, lines, instants_, colors, alpha, nullptr, no_pairs_, stats);
  stats.lines = lines_before;  // Lines of the picture are counted, not those of the pilot.
  sums = film.sums();
}

}  // namespace shutterline::engine
