#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "common/image/image.h"

/// FLIP: how different two pictures look when one is flipped to the other, 0 (alike) to 1, by pixel.
/// Written from the definitions in [andersson2020] (low dynamic range) and [andersson2021] (high).
namespace shutterline::bench {

/// Pixels a degree of a viewer 0.7 m before a screen 0.7 m and 3840 pixels wide: FLIP's own default.
inline constexpr double kFlipPixelsPerDegree = 0.7 * 3840 / 0.7 * 3.14159265358979323846 / 180;

/// Of linear colours, clamped to [0, 1]. Neighbours beyond a picture's border are its border's pixels.
/// INVALID_ARGUMENT for pictures of different or no size, or without R, G and B as their first channels.
absl::StatusOr<std::vector<double>> FlipLdr(const Image& test, const Image& reference,
                                            double pixels_per_degree = kFlipPixelsPerDegree);

/// The exposures, in stops, at which [andersson2021] compares: from where the reference's brightest pixel
/// is nearly white to where its median is. `count` >= 2 steps, both ends included.
struct ExposureRange {
  double start = 0, stop = 0;
  int count = 2;
};

/// Of a reference's luminances. Where the median is black, that of what is not black is taken, which the
/// definition leaves open; {0, 0, 2} for a black picture.
ExposureRange FlipExposures(const Image& reference);

/// The largest LDR-FLIP of each pixel over the exposures, each tone-mapped with the ACES fit.
absl::StatusOr<std::vector<double>> FlipHdr(const Image& test, const Image& reference,
                                            const ExposureRange& exposures,
                                            double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace shutterline::bench
