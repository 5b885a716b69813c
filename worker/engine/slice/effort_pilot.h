#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/engine/render/stats.h"
#include "worker/engine/sampling/shutter_curve.h"
#include "worker/engine/slice/class_resolver.h"
#include "worker/engine/slice/line_class.h"
#include "worker/engine/slice/tile_colors.h"
#include "worker/engine/slice/tile_strata.h"
#include "worker/engine/visibility/color_film.h"
#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

/// Renders a tile with one line a pixel of each of two families at a few instants, in parts whose differences
/// tell how fast the picture changes with the samples, in time and in space. Every triangle has one colour,
/// which the film guesses. Keeps its memory; one per thread.
class EffortPilot {
 public:
  struct Findings {
    int64_t samples = 0;  ///< (line, instant) pairs a pixel.
    /// RMS over the tile's pixels and colour channels of one half of the instants minus the other: of every
    /// four the first and the last, and the two between. What changes linearly is equal in both.
    double time_difference = 0;
    /// The same of one family's line minus the other's, as far as both halves agree on it: what lines miss as
    /// things move is another at other instants, and averages out without more lines.
    double space_difference = 0;
    /// Textures that move were seen, by points (ColorFilm::HasPoints): the differences tell how they look.
    bool sees_moving_textures = false;
    /// The longest motion among textured triangles that were seen as one colour each: the differences do not
    /// tell.
    double textured_motion_pixels = 0;
  };

  /// The first and the last of `classes` are of different families. `instants`: a multiple of 4, or 1 where
  /// nothing moves. Writes over the film.
  Findings Fly(TileStrata& strata, const std::vector<LineClass>& classes, int64_t instants,
               const ShutterCurve& shutter, TileColors& colors, ColorFilm& film, const AlphaSource* alpha,
               RenderStats& stats);

 private:
  using Sums = std::vector<std::array<double, 4>>;

  void RenderPart(TileStrata& strata, const LineClass& lines, int64_t instants, double offset, bool inner,
                  const ShutterCurve& shutter, TileColors& colors, ColorFilm& film, const AlphaSource* alpha,
                  RenderStats& stats, Sums& sums);

  ClassResolver resolver_;
  PairWeights no_pairs_;
  std::vector<double> instants_;
  std::array<std::array<Sums, 2>, 2> parts_;  // By family, and half of the instants.
};

}  // namespace shutterline::engine
