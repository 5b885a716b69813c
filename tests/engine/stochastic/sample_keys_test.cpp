#include "worker/engine/stochastic/sample_keys.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace shutterline::engine::sample_keys_test {
namespace {

/// One point in every elementary box: a (0, m, 3)-net.
TEST(StratifiedPattern, PowersOfTwoAreNets) {
  for (int m = 0; m <= 8; ++m) {
    const int spp = 1 << m;
    const StratifiedPattern pattern(3, 1, spp);
    for (const int pixel : {0, 1, 77}) {
      for (int i = 0; i <= m; ++i) {
        for (int j = 0; i + j <= m; ++j) {
          const int k = m - i - j;
          std::set<int> boxes;
          for (int s = 0; s < spp; ++s) {
            const StratifiedPoint p = pattern.At(pixel, 5 * pixel, s);
            boxes.insert((int(p.x * float(1 << i)) << (j + k)) + (int(p.y * float(1 << j)) << k) +
                         int(p.t * float(1 << k)));
          }
          ASSERT_EQ(int(boxes.size()), spp) << "m " << m << " cut " << i << " " << j << " " << k;
        }
      }
    }
  }
}

TEST(StratifiedPattern, EveryPointIsUniform) {
  constexpr int kSpp = 8, kPixels = 20000, kBins = 16;
  const StratifiedPattern pattern(11, 0, kSpp);
  for (int s = 0; s < kSpp; ++s) {
    // x, y, time within the stratum; and x against y.
    std::vector<std::vector<int>> counts(3, std::vector<int>(kBins));
    std::vector<int> joint(kBins * kBins);
    for (int i = 0; i < kPixels; ++i) {
      const StratifiedPoint p = pattern.At(i % 200, i / 200, s);
      const int x = int(p.x * kBins), y = int(p.y * kBins);
      ++counts[0][size_t(x)];
      ++counts[1][size_t(y)];
      ++counts[2][size_t((double(p.t) * kSpp - s) * kBins)];
      ++joint[size_t(x * kBins + y)];
    }
    const auto chi_squared = [&](const std::vector<int>& c) {
      const double expected = double(kPixels) / double(c.size());
      double sum = 0;
      for (const int n : c) sum += (n - expected) * (n - expected) / expected;
      return sum;
    };
    for (const auto& c : counts) EXPECT_LT(chi_squared(c), 15 + 6 * std::sqrt(30.0)) << "stratum " << s;
    EXPECT_LT(chi_squared(joint), 255 + 6 * std::sqrt(510.0)) << "stratum " << s;
  }
}

TEST(StratifiedPattern, DigitsBeginAnewUnderAnotherScrambling) {
  const StratifiedPattern pattern(1, 0, 1 << 20);
  int equal = 0;
  for (int s = 0; s < 64; ++s) {
    EXPECT_EQ(StratifiedPattern::Digits(s), StratifiedPattern::Digits(s + 65536));
    equal += pattern.At(3, 4, s).x == pattern.At(3, 4, s + 65536).x;
  }
  EXPECT_LT(equal, 4);
}

}  // namespace
}  // namespace shutterline::engine::sample_keys_test
