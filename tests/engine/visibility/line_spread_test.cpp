#include "worker/engine/visibility/line_spread.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace shutterline::engine {
namespace {

const std::vector<PixelFilter>& Filters() {
  static const std::vector<PixelFilter> filters = {
      {FilterKind::kBox, 0.5},      {FilterKind::kBox, 1.2},      {FilterKind::kTriangle, 1},
      {FilterKind::kGaussian, 1.5}, {FilterKind::kGaussian, 4.0}, {FilterKind::kBlackmanHarris, 2}};
  return filters;
}

/// Whatever a step is cut into, each column takes the same of it, in whole numbers.
TEST(LineSpread, PiecesOfAStepAddUpExactly) {
  for (uint32_t seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    const PixelFilter& filter = Filters()[seed % Filters().size()];
    const LineSpread spread(filter, 1 << random() % 5, int64_t{1} << random() % 23);
    const int32_t step = int32_t(random() % 64) << kSubpixelBits;
    std::vector<int32_t> cuts = {step, step + kSubpixelsPerPixel};
    for (int i = int(random() % 20); i > 0; --i) {
      // Far apart or next to one another.
      cuts.push_back(i % 3 == 0 ? std::min(cuts.back() + 1, step + kSubpixelsPerPixel)
                                : step + int32_t(random() % kSubpixelsPerPixel));
    }
    std::sort(cuts.begin(), cuts.end());
    LineSpread::Weights sums{};
    for (size_t i = 0; i + 1 < cuts.size(); ++i) {
      if (cuts[i] == cuts[i + 1]) continue;
      LineSpread::Weights weights;
      spread.Along(cuts[i], cuts[i + 1], weights);
      for (size_t k = 0; k < size_t(spread.taps()); ++k) {
        EXPECT_GE(weights[k], 0) << "seed " << seed;
        EXPECT_EQ(weights[k], std::floor(weights[k])) << "seed " << seed;
        sums[k] += weights[k];
      }
    }
    for (int k = 0; k < spread.taps(); ++k) EXPECT_EQ(sums[size_t(k)], spread.Whole(k)) << "seed " << seed;
  }
}

/// All columns together take of a piece what its length says.
TEST(LineSpread, APieceIsWorthItsLength) {
  for (const PixelFilter& filter : Filters()) {
    const LineSpread spread(filter, 4, 16);
    std::mt19937 random(3);
    for (int i = 0; i < 200; ++i) {
      const auto a = int32_t(random() % kSubpixelsPerPixel), b = int32_t(random() % kSubpixelsPerPixel);
      if (a == b) continue;
      LineSpread::Weights weights;
      spread.Along(std::min(a, b), std::max(a, b), weights);
      double sum = 0;
      for (int k = 0; k < spread.taps(); ++k) sum += weights[size_t(k)];
      EXPECT_EQ(sum, double(std::abs(a - b)) * PixelFilter::kWhole);
    }
  }
}

/// A pixel's total is that of all strips of all lines around it, and a double holds it at any number of
/// instants.
TEST(LineSpread, APixelSeesItsTotal) {
  for (const PixelFilter& filter : Filters()) {
    for (const int lines : {1, 2, 16}) {
      for (const int64_t instants :
           {int64_t{1}, int64_t{3}, int64_t{1} << 12, int64_t{65535}, int64_t{1} << 22}) {
        const LineSpread spread(filter, lines, instants);
        EXPECT_LE(spread.PixelTotal(), uint64_t{1} << 53);
        double sum = 0;
        for (int strip = 0; strip < lines; ++strip) {
          for (int d = 0; d < spread.taps(); ++d) {
            for (int k = 0; k < spread.taps(); ++k) sum += spread.Whole(k) * spread.Across(strip, d);
          }
        }
        EXPECT_EQ(uint64_t(sum) * 2 * uint64_t(instants), spread.PixelTotal());
      }
    }
  }
}

}  // namespace
}  // namespace shutterline::engine
