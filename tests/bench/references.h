#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "common/image/image.h"
#include "tests/bench/point_probe.h"
#include "tests/bench/tile_subset.h"

namespace shutterline::bench {

/// The truth, twice: two halves of independent noise, and how large that noise is.
struct ReferenceHalves {
  Image a, b;
  int spp = 0;  ///< Of both halves together.
  /// Root of the mean, over pixels and channels, of the variance of (a + b) / 2: the noise that a naive
  /// comparison would add to every error.
  double noise = 0;

  Image Mean() const;
};

/// Where references are kept between runs; empty: nowhere.
struct ReferenceCache {
  std::string folder;
};

/// The tiles by the reference integrator at `spp` points a pixel in all (a multiple of 4). Kept under a
/// digest of everything that it depends on: the frame's moving triangles, their shades and the tiles.
absl::StatusOr<ReferenceHalves> RenderReference(std::shared_ptr<const engine::FrameScene> frame_scene,
                                                int frame, const RenderSettings& settings,
                                                const TileSubset& subset, int spp, int threads,
                                                const ReferenceCache& cache);

struct LineReference {
  ReferenceHalves traced;  ///< Every point shaded where it hits, as the reference does.
  /// From the same points, every (triangle, pixel) pair shaded once, at the mean of its hits, as the line
  /// integrator does (but for textures that move, which it shades more often).
  ReferenceHalves cached;
};

/// The same with all points on the lines of `settings.pattern`, uniform along them and over the shutter:
/// what lines cannot see is missing from it too. What a line integrator differs from it is not the fault of
/// its having few lines.
absl::StatusOr<LineReference> RenderLineReference(const PointProbe& probe, int frame,
                                                  const RenderSettings& settings, const TileSubset& subset,
                                                  int spp, int threads, const ReferenceCache& cache);

}  // namespace shutterline::bench
