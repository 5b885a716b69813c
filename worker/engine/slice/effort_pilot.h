#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/engine/render/stats.h"
#include "worker/engine/slice/class_resolver.h"
#include "worker/engine/slice/line_class.h"
#include "worker/engine/slice/tile_colors.h"
#include "worker/engine/slice/tile_strata.h"
#include "worker/engine/visibility/color_film.h"
#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

/// Renders a tile with little, in two halves whose difference tells how fast the picture changes with the
/// samples. Every triangle has one colour, which the film guesses. Keeps its memory; one per thread.
class EffortPilot {
 public:
  struct Findings {
    double difference = 0;  ///< RMS over the tile's pixels and colour channels of one half minus the other.
    int64_t samples = 0;    ///< (line, instant) pairs a pixel, both halves together.
    double textured_motion_pixels = 0;  ///< The longest motion among the textured triangles that were seen.
  };

  /// Over time: one line a pixel of each family, at `instants` instants, a multiple of 4. One half has the
  /// first and the last of every four, the other those between: what changes linearly is equal in both, and
  /// what stands still is the same.
  Findings OverTime(TileStrata& strata, const std::vector<LineClass>& classes, int64_t instants,
                    TileColors& colors, ColorFilm& film, RenderStats& stats);

  /// Over space, where nothing moves: the even and the odd classes of each family.
  Findings OverSpace(TileStrata& strata, const std::vector<LineClass>& classes, TileColors& colors,
                     ColorFilm& film, RenderStats& stats);

 private:
  void Resolve(TileStrata& strata, const LineClass& lines, TileColors& colors, RenderStats& stats);
  void EndFirstHalf(ColorFilm& film);
  /// RMS of the first half minus what is on the film now, both of the weight `total` a pixel.
  double Difference(const ColorFilm& film, double total) const;

  ClassResolver resolver_;
  PairWeights no_pairs_;
  std::vector<double> instants_;
  std::vector<std::array<double, 4>> first_half_;
};

}  // namespace shutterline::engine
