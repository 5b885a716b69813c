#include "tests/bench/errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/status_macros.h"
#include "common/math/compensated_sum.h"
#include "tests/bench/flip.h"
#include "tests/bench/tile_subset.h"

namespace shutterline::bench {
namespace {

absl::StatusOr<UnbiasedError> MeanError(const std::vector<Image>& pictures, const ReferenceHalves& reference,
                                        const std::vector<uint8_t>& mask) {
  if (!mask.empty() && MaskShare(mask) == 0) return UnbiasedError{};
  UnbiasedError mean;
  for (const Image& picture : pictures) {
    SL_ASSIGN_OR_RETURN(const UnbiasedError one,
                        MeasureUnbiasedError(picture, reference.a, reference.b, mask));
    mean.d += one.d / double(pictures.size());
    mean.standard_error += one.standard_error / double(pictures.size());
    mean.pixels = one.pixels;
  }
  return mean;
}

/// The mean over pixels of the variance of one of several independent pictures.
double Variance(const std::vector<Image>& pictures) {
  if (pictures.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  CompensatedSum sum;
  const size_t values = pictures[0].values().size();
  const double n = double(pictures.size());
  for (size_t i = 0; i < values; ++i) {
    if (i % 4 == 3) continue;
    double mean = 0, squares = 0;
    for (const Image& picture : pictures) mean += double(picture.values()[i]) / n;
    for (const Image& picture : pictures) squares += std::pow(double(picture.values()[i]) - mean, 2);
    sum.Add(squares / (n - 1));
  }
  return sum.Total() / (0.75 * double(values));
}

}  // namespace

absl::StatusOr<ErrorFigures> MeasureErrors(const std::vector<Image>& pictures,
                                           const ReferenceHalves& reference, const BenchMasks& masks,
                                           int threads) {
  ErrorFigures result;
  SL_ASSIGN_OR_RETURN(result.whole, MeanError(pictures, reference, {}));
  SL_ASSIGN_OR_RETURN(result.moving, MeanError(pictures, reference, masks.moving));
  SL_ASSIGN_OR_RETURN(result.static_edges, MeanError(pictures, reference, masks.static_edges));
  SL_ASSIGN_OR_RETURN(result.disocclusions, MeanError(pictures, reference, masks.disocclusions));
  result.bias_squared = result.whole.d - Variance(pictures);
  const Image mean = reference.Mean();
  SL_ASSIGN_OR_RETURN(const Comparison comparison, Compare(pictures.front(), mean));
  result.relative_mse = comparison.relative_mse;
  result.psnr = comparison.psnr;
  SL_ASSIGN_OR_RETURN(const FlipFigures flip, MeasureFlip(pictures.front(), mean, threads));
  result.flip_ldr = flip.ldr;
  result.flip_hdr = flip.hdr;
  return result;
}

absl::StatusOr<FlipFigures> MeasureFlip(const Image& test, const Image& reference, int threads) {
  const ExposureRange exposures = FlipExposures(reference);
  const int tiles = reference.height() / kTileSize, count = std::min(tiles, kFlipTiles);
  std::vector<FlipFigures> figures(static_cast<size_t>(count));
  std::vector<absl::Status> statuses(static_cast<size_t>(count));
  ParallelFor(count, threads, [&](int i, int) {
    // Steps of the golden ratio spread over rows and columns alike.
    const int tile = tiles == count ? i : int(tiles * std::fmod(0.6180339887 * (i + 1), 1.0));
    const Image a = TileOf(test, tile), b = TileOf(reference, tile);
    const auto low = FlipLdr(a, b), high = FlipHdr(a, b, exposures);
    if (!low.ok() || !high.ok()) {
      statuses[size_t(i)] = low.ok() ? high.status() : low.status();
      return;
    }
    for (size_t k = 0; k < low->size(); ++k) {
      figures[size_t(i)].ldr += (*low)[k] / double(low->size());
      figures[size_t(i)].hdr += (*high)[k] / double(low->size());
    }
  });
  FlipFigures result;
  for (size_t i = 0; i < figures.size(); ++i) {
    SL_RETURN_IF_ERROR(statuses[i]);
    result.ldr += figures[i].ldr / count;
    result.hdr += figures[i].hdr / count;
  }
  return result;
}

}  // namespace shutterline::bench
