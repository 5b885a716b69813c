#include "worker/engine/slice/effort_pilot.h"

#include <algorithm>
#include <cmath>

#include "common/math/tolerance.h"
#include "worker/engine/visibility/time_samples.h"

namespace shutterline::engine {

EffortPilot::Findings EffortPilot::OverTime(TileStrata& strata, const std::vector<LineClass>& classes,
                                            int64_t instants, TileColors& colors, ColorFilm& film,
                                            RenderStats& stats) {
  // The first class of the first family and the last one of the last.
  const std::array<const LineClass*, 2> lines{&classes.front(), &classes.back()};
  film.Reset(strata.mesh().rect().Area());
  colors.BeginGuessing(strata.mesh(), film);
  for (const bool second : {false, true}) {
    if (second) EndFirstHalf(film);
    for (size_t c = 0; c < lines.size(); ++c) {
      instants_.clear();
      for (int64_t i = 0; i < instants; ++i) {
        const bool is_inner = i % 4 == 1 || i % 4 == 2;
        if (is_inner != second) continue;
        instants_.push_back(TimeSamples::InstantAt(i, instants, c == 0 ? 0.25 : 0.75));
      }
      Resolve(strata, *lines[c], colors, stats);
    }
  }
  const auto samples = int64_t(lines.size()) * instants;
  Findings findings{.difference = Difference(film, double(samples / 2) * double(kSubpixelsPerPixel)),
                    .samples = samples};
  for (size_t i = 0; i < strata.mesh().triangles().size(); ++i) {
    const TileMeshTriangle& triangle = strata.mesh().triangles()[i];
    if (triangle.shading_bins_log2 > 0 && colors.WasSeen(uint32_t(i))) {
      findings.textured_motion_pixels =
          std::max(findings.textured_motion_pixels, double(triangle.motion_pixels));
    }
  }
  return findings;
}

EffortPilot::Findings EffortPilot::OverSpace(TileStrata& strata, const std::vector<LineClass>& classes,
                                             TileColors& colors, ColorFilm& film, RenderStats& stats) {
  film.Reset(strata.mesh().rect().Area());
  colors.BeginGuessing(strata.mesh(), film);
  instants_.assign(1, 0.5);
  for (const size_t half : {0u, 1u}) {
    if (half == 1) EndFirstHalf(film);
    for (size_t c = half; c < classes.size(); c += 2) Resolve(strata, classes[c], colors, stats);
  }
  const auto samples = int64_t(classes.size());
  return {.difference = Difference(film, double(samples) / 2 * double(kSubpixelsPerPixel)),
          .samples = samples};
}

void EffortPilot::Resolve(TileStrata& strata, const LineClass& lines, TileColors& colors,
                          RenderStats& stats) {
  const int64_t before = stats.lines;
  resolver_.Resolve(strata, lines, instants_, colors, no_pairs_, stats);
  stats.lines = before;  // Lines of the picture are counted, not those of the pilot.
}

void EffortPilot::EndFirstHalf(ColorFilm& film) {
  first_half_ = film.sums();
  film.Reset(int64_t(first_half_.size()));
}

double EffortPilot::Difference(const ColorFilm& film, double total) const {
  double sum = 0;
  for (size_t i = 0; i < first_half_.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) {
      const double d = (first_half_[i][c] - film.sums()[i][c]) / total;
      sum += d * d;
    }
  }
  return std::sqrt(sum / (3 * double(first_half_.size())));
}

}  // namespace shutterline::engine
