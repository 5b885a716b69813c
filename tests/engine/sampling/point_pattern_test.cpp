#include "worker/engine/sampling/point_pattern.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace shutterline::engine {
namespace {

std::array<double, 3> AsArray(const PixelPoint& p) {
  return {p.x, p.y, p.t};
}

TEST(PointPattern, EveryAxisIsStratifiedForEveryPowerOfTwo) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const PixelPoints points = PointPattern(seed, 3).Pixel(17, 4 + int(seed));
    for (int k = 0; k <= 12; ++k) {
      std::array<std::set<int>, 3> cells;
      for (uint32_t i = 0; i < 1u << k; ++i) {
        const auto p = AsArray(points.At(i));
        for (int d = 0; d < 3; ++d) cells[d].insert(int(std::ldexp(p[d], k)));
      }
      for (int d = 0; d < 3; ++d) EXPECT_EQ(cells[d].size(), 1u << k) << "seed " << seed << " axis " << d;
    }
  }
}

TEST(PointPattern, PositionsAreANet) {
  // Any aligned block of 2^k points has one in every elementary rectangle of area 2^-k.
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const PixelPoints points = PointPattern(seed, 0).Pixel(1, 2);
    for (int k = 0; k <= 10; ++k) {
      for (uint32_t block = 0; block < 3; ++block) {
        for (int a = 0; a <= k; ++a) {
          std::set<std::pair<int, int>> cells;
          for (uint32_t i = 0; i < 1u << k; ++i) {
            const PixelPoint p = points.At((block << k) + i);
            cells.emplace(int(std::ldexp(p.x, a)), int(std::ldexp(p.y, k - a)));
          }
          EXPECT_EQ(cells.size(), 1u << k) << "seed " << seed << " block " << block << " split " << a;
        }
      }
    }
  }
}

TEST(PointPattern, SpaceAndTimeAreStratifiedTogether) {
  // The three dimensions have quality parameter t = 1: no box of volume 2^-(k-1) has other than 2 points.
  const PixelPoints points = PointPattern(9, 9).Pixel(9, 9);
  for (int k = 1; k <= 9; ++k) {
    for (int a = 0; a < k; ++a) {
      for (int b = 0; a + b < k; ++b) {
        std::vector<int> counts(size_t{1} << (k - 1), 0);
        for (uint32_t i = 0; i < 1u << k; ++i) {
          const PixelPoint p = points.At(i);
          const int cell = (int(std::ldexp(p.x, a)) << b | int(std::ldexp(p.y, b))) << (k - 1 - a - b) |
                           int(std::ldexp(p.t, k - 1 - a - b));
          ++counts[cell];
        }
        for (const int count : counts) EXPECT_EQ(count, 2);
      }
    }
  }
}

TEST(PointPattern, EachPointIsUniformOverPixels) {
  // Point i of a pixel is a uniform random variable: mean ½, variance 1/12, and the two halves of every
  // interval of four levels equally likely whatever came before.
  constexpr int kSide = 256, kCount = kSide * kSide;
  const PointPattern pattern(1234, 5);
  for (const uint32_t index : {0u, 1u, 2u, 5u, 63u, 1000u}) {
    std::array<double, 3> sum{}, sum2{};
    std::array<std::array<int, 16>, 3> histogram{};
    double xy = 0, xt = 0, yt = 0;
    for (int i = 0; i < kCount; ++i) {
      const PixelPoint p = pattern.Pixel(i % kSide, i / kSide).At(index);
      const auto v = AsArray(p);
      for (int d = 0; d < 3; ++d) {
        ASSERT_GE(v[d], 0);
        ASSERT_LT(v[d], 1);
        sum[d] += v[d];
        sum2[d] += (v[d] - 0.5) * (v[d] - 0.5);
        ++histogram[d][int(16 * v[d])];
      }
      xy += (p.x - 0.5) * (p.y - 0.5);
      xt += (p.x - 0.5) * (p.t - 0.5);
      yt += (p.y - 0.5) * (p.t - 0.5);
    }
    const double root = std::sqrt(double(kCount));
    for (int d = 0; d < 3; ++d) {
      EXPECT_NEAR(sum[d] / kCount, 0.5, 5 * std::sqrt(1 / 12.0) / root);
      EXPECT_NEAR(sum2[d] / kCount, 1 / 12.0, 5 * std::sqrt(1 / 180.0) / root);
      double chi2 = 0;
      for (const int n : histogram[d]) chi2 += (n - kCount / 16.0) * (n - kCount / 16.0) / (kCount / 16.0);
      EXPECT_LT(chi2, 15 + 6 * std::sqrt(30.0)) << "axis " << d << " point " << index;
    }
    for (const double product : {xy, xt, yt}) EXPECT_NEAR(product / kCount, 0, 5 / 12.0 / root);
  }
}

TEST(PointPattern, PointsOfAPixelAreIndependentWithinTheirStrata) {
  // Nested uniform scrambling: given the stratum, where a point lies in it says nothing about another's
  // place in its own. Points 0 and 1 lie in different halves of every axis.
  constexpr int kCount = 40000;
  const PointPattern pattern(77, 0);
  std::array<double, 3> product{};
  for (int i = 0; i < kCount; ++i) {
    const PixelPoints points = pattern.Pixel(i, 3 * i);
    const auto a = AsArray(points.At(0)), b = AsArray(points.At(1));
    for (int d = 0; d < 3; ++d) {
      product[d] += (2 * a[d] - std::floor(2 * a[d]) - 0.5) * (2 * b[d] - std::floor(2 * b[d]) - 0.5);
    }
  }
  for (const double p : product) EXPECT_NEAR(p / kCount, 0, 5 / 12.0 / std::sqrt(double(kCount)));
}

/// Correlation of the errors that two patterns make on the same integral, over many pixels.
double ErrorCorrelation(const PointPattern& a, int ax, const PointPattern& b, int bx) {
  constexpr int kSide = 100, kPoints = 16;
  double aa = 0, bb = 0, ab = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      // Half-space x + 0.7 y + 0.4 t < 1.05, by symmetry exactly one half of the cube.
      const auto error = [&](const PixelPoints& points) {
        int inside = 0;
        for (uint32_t i = 0; i < kPoints; ++i) {
          const PixelPoint p = points.At(i);
          inside += p.x + 0.7 * p.y + 0.4 * p.t < 1.05;
        }
        return double(inside) / kPoints - 0.5;
      };
      const double ea = error(a.Pixel(x + ax, y)), eb = error(b.Pixel(x + bx, y));
      aa += ea * ea;
      bb += eb * eb;
      ab += ea * eb;
    }
  }
  return ab / std::sqrt(aa * bb);
}

TEST(PointPattern, SeedsFramesAndPixelsAreIndependent) {
  constexpr double kFiveSigma = 5 / 100.0;
  const PointPattern base(1, 1);
  EXPECT_NEAR(ErrorCorrelation(base, 0, base, 0), 1, 1e-12);
  EXPECT_NEAR(ErrorCorrelation(base, 0, PointPattern(2, 1), 0), 0, kFiveSigma);
  EXPECT_NEAR(ErrorCorrelation(base, 0, PointPattern(1, 2), 0), 0, kFiveSigma);
  EXPECT_NEAR(ErrorCorrelation(base, 0, PointPattern(1ull << 63 | 1, 1), 0), 0, kFiveSigma);
  EXPECT_NEAR(ErrorCorrelation(base, 0, base, 1), 0, kFiveSigma);
}

TEST(PointPattern, ErrorFallsFasterThanThatOfRandomPoints) {
  // 64 random points would have a standard deviation of 1/16 on this half of the cube.
  const PointPattern pattern(5, 5);
  double squares = 0;
  constexpr int kPixels = 2000;
  for (int i = 0; i < kPixels; ++i) {
    const PixelPoints points = pattern.Pixel(i, i / 7);
    int inside = 0;
    for (uint32_t k = 0; k < 64; ++k) {
      const PixelPoint p = points.At(k);
      inside += p.x + 0.7 * p.y + 0.4 * p.t < 1.05;
    }
    squares += std::pow(inside / 64.0 - 0.5, 2);
  }
  EXPECT_LT(std::sqrt(squares / kPixels), 0.5 / 16);
}

}  // namespace
}  // namespace shutterline::engine
