#pragma once

#include <absl/status/statusor.h>
#include <absl/types/span.h>

#include <cstdint>
#include <string>

#include "common/image/image.h"

/// Error measures on linear values, before any tone mapping. All are over the channels R, G and B, each
/// pixel and channel weighing the same (alpha counts in `largest_difference` only); sums are compensated,
/// in double, in the order of the pixels, so equal pictures give equal figures to the last bit.
///
/// Every measure refuses (INVALID_ARGUMENT) pictures of different sizes or channels, naming both, pictures
/// without R, G and B, empty ones, and a NaN or an infinity in any channel, naming picture, pixel and
/// channel. Thread-safe.
namespace shutterline {

/// How a picture T differs from a reference R.
struct Comparison {
  double rmse = 0;                ///< sqrt(mean (T − R)²)
  double psnr = 0;                ///< −20 log10(rmse), decibels with peak 1; +infinity if rmse is 0.
  double relative_mse = 0;        ///< mean (T − R)² / (R + 0.01)²
  double largest_difference = 0;  ///< max |T − R|, over all channels, A included.
  int largest_x = 0, largest_y = 0;
  std::string largest_channel;  ///< The first such pixel and channel, in the order of rows.
};

absl::StatusOr<Comparison> Compare(const Image& test, const Image& reference);

/// The mean squared error against a noisy reference, without the reference's noise.
///
/// The reference is given as two halves A and B of independent noise. d = mean (T − A)(T − B) has the
/// expectation of the true mean squared error (plus T's own variance, if T is stochastic): the halves'
/// errors multiply and cancel, where (T − (A + B) / 2)² would add their variance. It may come out negative.
struct UnbiasedError {
  double d = 0;
  /// Standard error of d: the sample deviation of the pixels' products over the root of their number. It
  /// takes pixels as independent, and counts that the error differs from place to place as uncertainty
  /// too, so it errs on the wide side. Infinity for a single pixel.
  double standard_error = 0;
  int64_t pixels = 0;  ///< That the mask leaves.

  /// The true error is too small for this reference to tell from none.
  bool BelowFloor() const { return d < 0; }
  /// sqrt(d); 0 below the floor, where it means nothing: ask BelowFloor() first.
  double Rmse() const;
  /// "RMSE 0.0042 (D 1.76e-05 ± 3e-07)", with 2 standard errors, or "below the reference's floor (D ...)".
  std::string ToString() const;
};

/// `mask`: empty for the whole frame, or a value for each pixel, row by row; 0 leaves the pixel out. A
/// mask of another length, or that leaves no pixel, is refused.
absl::StatusOr<UnbiasedError> MeasureUnbiasedError(const Image& test, const Image& half_a,
                                                   const Image& half_b, absl::Span<const uint8_t> mask = {});

}  // namespace shutterline
