#include "tests/bench/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/scenes/random.h"

namespace shutterline::bench {
namespace {

Image Constant(int width, int height, float r, float g, float b) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float* p = image.At(x, y);
      p[0] = r;
      p[1] = g;
      p[2] = b;
      p[3] = 1;
    }
  }
  return image;
}

Image RandomImage(int width, int height, uint64_t seed, double most = 1) {
  scenes::Random random(seed);
  Image image(width, height);
  for (float& value : image.values()) value = float(random.Uniform(0, most));
  return image;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value / double(values.size());
  return sum;
}

TEST(Flip, AlikeIsZero) {
  const Image image = RandomImage(24, 16, 1);
  const auto low = FlipLdr(image, image).value(), high = FlipHdr(image, image, FlipExposures(image)).value();
  for (const double value : low) EXPECT_EQ(value, 0);
  for (const double value : high) EXPECT_EQ(value, 0);
}

TEST(Flip, IsSymmetricAndWithinZeroAndOne) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    const Image a = RandomImage(20, 12, seed), b = RandomImage(20, 12, seed + 100);
    const auto ab = FlipLdr(a, b).value(), ba = FlipLdr(b, a).value();
    for (size_t i = 0; i < ab.size(); ++i) {
      EXPECT_NEAR(ab[i], ba[i], 1e-12) << "seed " << seed;
      EXPECT_GE(ab[i], 0);
      EXPECT_LE(ab[i], 1);
    }
  }
}

/// A picture of one colour is its own blur and has no features, so only the colour's difference is left.
/// Black to white by hand: lightness 0 and 100, no chroma, hence 100^0.7 = 25.12. The largest difference is
/// green to blue: with Hunt's scaling L*a*b* are (87.73, -75.61, 72.97) and (32.30, 25.58, -34.84), the
/// distance 55.44 + √(101.19² + 107.81²) = 203.3, to the 0.7: 41.28. The knee is at 0.4 × 41.28 = 16.51, so
/// black to white is 0.95 + 0.05 × (25.12 − 16.51) / (41.28 − 16.51) = 0.9674.
TEST(Flip, BlackToWhiteByHand) {
  for (const int size : {1, 9}) {
    const auto flip = FlipLdr(Constant(size, size, 0, 0, 0), Constant(size, size, 1, 1, 1)).value();
    for (const double value : flip) EXPECT_NEAR(value, 0.9674, 2e-4);
  }
}

/// The largest difference that the metric knows is exactly 1.
TEST(Flip, GreenToBlueIsOne) {
  EXPECT_NEAR(FlipLdr(Constant(1, 1, 0, 1, 0), Constant(1, 1, 0, 0, 1))->front(), 1, 1e-6);
}

/// A small difference of grey: L* of 0.5 and 0.51 linear are 76.069 and 76.684 (116 ∛Y − 16), 0.615 apart:
/// 0.615^0.7 = 0.7116; × 0.95 / 16.51 = 0.0409.
TEST(Flip, NearGreysByHand) {
  const auto flip = FlipLdr(Constant(1, 1, 0.5f, 0.5f, 0.5f), Constant(1, 1, 0.51f, 0.51f, 0.51f)).value();
  const double lightness = 116 * (std::cbrt(0.51) - std::cbrt(0.5));
  EXPECT_NEAR(flip.front(), std::pow(lightness, 0.7) * 0.95 / 16.51, 2e-4);
}

/// Where the picture has an edge that the other has not, the colour's difference counts for more: at the
/// border of a step it is above that of the same difference without an edge far away.
TEST(Flip, MissingEdgesWeighMore) {
  Image step = Constant(64, 33, 0.3f, 0.3f, 0.3f);
  for (int y = 0; y < 33; ++y) {
    for (int x = 32; x < 64; ++x) {
      for (int c = 0; c < 3; ++c) step.At(x, y)[c] = 0.5f;
    }
  }
  const auto flip = FlipLdr(step, Constant(64, 33, 0.3f, 0.3f, 0.3f)).value();
  const double at_edge = flip[16 * 64 + 33], inside = flip[16 * 64 + 60], outside = flip[16 * 64 + 3];
  EXPECT_GT(at_edge, inside + 0.05);
  EXPECT_NEAR(outside, 0, 1e-9);
}

TEST(Flip, BlurredNoiseIsSeenLessThanAStep) {
  scenes::Random random(5);
  Image noise = Constant(48, 48, 0.5f, 0.5f, 0.5f), shift = Constant(48, 48, 0.6f, 0.6f, 0.6f);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 48; ++x) {
      const float d = random.Bits() % 2 == 0 ? 0.1f : -0.1f;
      for (int c = 0; c < 3; ++c) noise.At(x, y)[c] += d;
    }
  }
  const Image grey = Constant(48, 48, 0.5f, 0.5f, 0.5f);
  const Image no_features = shift;
  EXPECT_GT(Mean(FlipLdr(no_features, grey).value()), 0.1);
  EXPECT_GT(Mean(FlipLdr(noise, grey).value()), 0);
}

/// At the range's ends the reference's brightest and its median luminance are tone-mapped to 0.85.
TEST(Flip, ExposuresMapMaximumAndMedianToNearWhite) {
  const Image image = RandomImage(31, 31, 3, 40);
  const ExposureRange range = FlipExposures(image);
  EXPECT_LT(range.start, range.stop);
  EXPECT_EQ(range.count, std::max(2, int(std::ceil(range.stop - range.start))));
  std::vector<double> luminances;
  for (int y = 0; y < 31; ++y) {
    for (int x = 0; x < 31; ++x) {
      const float* p = image.At(x, y);
      luminances.push_back(0.2126 * double(p[0]) + 0.7152 * double(p[1]) + 0.0722 * double(p[2]));
    }
  }
  std::sort(luminances.begin(), luminances.end());
  const auto aces = [](double x) {
    x *= 0.6;
    return (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
  };
  EXPECT_NEAR(aces(luminances.back() * std::exp2(range.start)), 0.85, 1e-4);
  EXPECT_NEAR(aces(luminances[luminances.size() / 2] * std::exp2(range.stop)), 0.85, 1e-4);
}

TEST(Flip, HighRangeSeesWhatIsAboveWhite) {
  const Image a = Constant(1, 1, 4, 4, 4), b = Constant(1, 1, 8, 8, 8);
  EXPECT_EQ(FlipLdr(a, b)->front(), 0);  // Both are white there.
  EXPECT_GT(FlipHdr(a, b, FlipExposures(b))->front(), 0.05);
}

TEST(Flip, RefusesOtherSizes) {
  EXPECT_FALSE(FlipLdr(Image(2, 2), Image(2, 3)).ok());
  EXPECT_FALSE(FlipLdr(Image(0, 0), Image(0, 0)).ok());
  EXPECT_FALSE(FlipHdr(Image(2, 2, {"Y"}), Image(2, 2, {"Y"}), {}).ok());
}

}  // namespace
}  // namespace shutterline::bench
