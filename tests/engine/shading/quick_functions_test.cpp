#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "worker/engine/shading/log2.h"
#include "worker/engine/shading/quick_angle.h"

namespace shutterline::engine {
namespace {

TEST(Log2, IsThatOfTheLibraryAndExactForPowersOfTwo) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-100, 100);
  for (int i = 0; i < 10000; ++i) {
    const double x = std::exp2(exponent(random));
    EXPECT_NEAR(Log2(x), std::log2(x), 2e-9) << x;
  }
  for (int i = -1022; i < 1024; ++i) EXPECT_EQ(Log2(std::ldexp(1.0, i)), i);
  EXPECT_EQ(Log2(std::numeric_limits<double>::infinity()), 1024);
}

TEST(Log2, NeverReachesTheNextIntegerBelowIt) {
  for (int i = 1; i < 60; ++i) EXPECT_LE(Log2(std::nextafter(std::ldexp(1.0, i), 0)), i);
}

TEST(QuickAngle, IsThatOfTheLibrary) {
  for (int i = -100000; i <= 100000; ++i) {
    const double angle = M_PI * i / 100000;
    const double y = 3 * std::sin(angle), x = 3 * std::cos(angle);
    EXPECT_NEAR(QuickAngle(y, x), std::atan2(y, x), 1e-9) << angle;
  }
  EXPECT_EQ(QuickAngle(0, 0), 0);
  EXPECT_EQ(QuickAngle(0, 1), 0);
  EXPECT_EQ(QuickAngle(1, 0), M_PI / 2);
  EXPECT_EQ(QuickAngle(-1, 0), -M_PI / 2);
  EXPECT_EQ(QuickAngle(0, -1), M_PI);
}

}  // namespace
}  // namespace shutterline::engine
