#include "worker/engine/shading/texture_sampler.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace shutterline::engine {
namespace {

TextureImage Image(int width, int height, const std::function<std::array<uint8_t, 3>(int, int)>& color) {
  TextureImage image;
  image.width = width;
  image.height = height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto c = color(x, y);
      for (const uint8_t channel : {c[0], c[1], c[2], uint8_t{255}}) image.rgba.push_back(channel);
    }
  }
  return image;
}

std::array<uint8_t, 3> Gray(int value) {
  return {uint8_t(value), uint8_t(value), uint8_t(value)};
}

V4f Sample(const MipPyramid& pyramid, const Texture& texture, const V2d& uv, double du = 0, double dv = 0) {
  return SampleTexture(pyramid, texture, uv, V2d(du, 0), V2d(0, dv));
}

TEST(TextureSampler, SrgbIsDecoded) {
  EXPECT_EQ(LinearFromSrgb8(0), 0);
  EXPECT_EQ(LinearFromSrgb8(255), 1);
  // Half of full radiance has the code 187.5; code 127.5 is 0.2122.
  EXPECT_NEAR((LinearFromSrgb8(187) + LinearFromSrgb8(188)) / 2, 0.5, 2e-3);
  EXPECT_NEAR((LinearFromSrgb8(127) + LinearFromSrgb8(128)) / 2, 0.2140, 2e-4);
  EXPECT_NEAR(LinearFromSrgb8(10), 10 / 255.0 / 12.92, 1e-7);
  const TextureImage image = Image(1, 1, [](int, int) { return Gray(128); });
  EXPECT_EQ(Sample(MipPyramid(image, TextureEncoding::kSrgb), {}, {0.3, 0.7}).x, LinearFromSrgb8(128));
}

TEST(TextureSampler, ConstantImagesAreConstantEverywhere) {
  const TextureImage image = Image(37, 11, [](int, int) { return std::array<uint8_t, 3>{200, 100, 50}; });
  const MipPyramid pyramid(image, TextureEncoding::kSrgb);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-3, 3);
  for (int i = 0; i < 1000; ++i) {
    const V4f c = Sample(pyramid, {}, {uniform(random), uniform(random)}, uniform(random), uniform(random));
    EXPECT_NEAR(c.x, LinearFromSrgb8(200), 2e-5) << "seed 1, sample " << i;
    EXPECT_NEAR(c.y, LinearFromSrgb8(100), 2e-5);
    EXPECT_NEAR(c.z, LinearFromSrgb8(50), 2e-5);
  }
}

TEST(TextureSampler, CheckersAverageInLinearLight) {
  const TextureImage image = Image(64, 64, [](int x, int y) { return Gray((x + y) % 2 ? 255 : 0); });
  const MipPyramid pyramid(image, TextureEncoding::kSrgb);
  // One pixel covers 2, 8 or all 64 texels.
  for (const double footprint : {2 / 64.0, 8 / 64.0, 1.0, 50.0}) {
    EXPECT_NEAR(Sample(pyramid, {}, {0.123, 0.456}, footprint, footprint).x, 0.5, 1e-4) << footprint;
  }
  // A footprint of two texels by none takes both.
  EXPECT_NEAR(Sample(pyramid, {}, {0.123, 0.456}, 0, 2 / 64.0).x, 0.5, 1e-4);
  // Half-way in between two levels of log2: the mean of both.
  const V2d black(0.5 / 64, 0.5 / 64);
  EXPECT_EQ(Sample(pyramid, {}, black, 1 / 64.0, 1 / 64.0).x, 0);
  EXPECT_NEAR(Sample(pyramid, {}, black, std::sqrt(2.0) / 64, std::sqrt(2.0) / 64).x, 0.25, 1e-4);
}

TEST(TextureSampler, LongFootprintsBlurAlongThemselvesAlone) {
  // Rows of one colour each: a footprint along a row shows the row, one across the rows their mean.
  const TextureImage image = Image(64, 64, [](int, int y) { return Gray(y % 2 ? 255 : 0); });
  const MipPyramid pyramid(image, TextureEncoding::kSrgb);
  const V2d on_white(0.4, 33.5 / 64), on_black(0.4, 32.5 / 64);
  for (const double texels : {2.0, 5.0, 12.0}) {
    EXPECT_NEAR(Sample(pyramid, {}, on_white, texels / 64, 0).x, 1, 1e-5) << texels;
    EXPECT_NEAR(Sample(pyramid, {}, on_black, texels / 64, 1 / 64.0).x, 0, 1e-5) << texels;
    EXPECT_NEAR(Sample(pyramid, {}, on_white, 0, 4 * std::floor(texels / 2) / 64).x, 0.5, 1e-5) << texels;
  }
  // Turned by 45 degrees it crosses the rows, and is no wider for it.
  const double d = 8 / 64.0;
  EXPECT_NEAR(SampleTexture(pyramid, {}, on_white, V2d(d, d), V2d(-d / 16, d / 16)).x, 0.5, 0.06);
  // Beyond 16 times as long as wide, it is blurred across as well.
  EXPECT_NEAR(Sample(pyramid, {}, on_white, 64 / 64.0, 1e-9).x, 0.5, 0.02);
}

TEST(TextureSampler, AlphaIsFilteredLinearly) {
  TextureImage image;
  image.width = 2;
  image.height = 1;
  image.rgba = {255, 255, 255, 0, 255, 255, 255, 128};
  for (const TextureEncoding encoding : {TextureEncoding::kSrgb, TextureEncoding::kLinear}) {
    const MipPyramid pyramid(image, encoding);
    EXPECT_NEAR(Sample(pyramid, {}, {0.5, 0.5}).w, 64 / 255.0, 1e-6);
    EXPECT_NEAR(Sample(pyramid, {}, {0.5, 0.5}, 1, 1).w, 64 / 255.0, 1e-4);
  }
}

TEST(TextureSampler, EveryLevelKeepsTheMean) {
  std::mt19937 random(9);
  for (const auto& [width, height] :
       {std::pair(7, 5), std::pair(64, 3), std::pair(1, 9), std::pair(100, 100)}) {
    const TextureImage image = Image(width, height, [&](int, int) { return Gray(int(random() % 256)); });
    const MipPyramid pyramid(image, TextureEncoding::kSrgb);
    double first = 0;
    for (int level = 0; level < pyramid.level_count(); ++level) {
      double sum = 0;
      for (int y = 0; y < pyramid.Height(level); ++y) {
        for (int x = 0; x < pyramid.Width(level); ++x) sum += double(pyramid.Texel(level, x, y).x);
      }
      const double mean = sum / pyramid.Width(level) / pyramid.Height(level);
      if (level == 0) first = mean;
      EXPECT_NEAR(mean, first, 5e-5) << width << " x " << height << ", level " << level;
    }
    EXPECT_EQ(pyramid.Width(pyramid.level_count() - 1), 1);
    EXPECT_EQ(pyramid.Height(pyramid.level_count() - 1), 1);
  }
}

TEST(TextureSampler, WrapModes) {
  const std::array<int, 12> repeat{0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2};
  const std::array<int, 12> mirror{0, 1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0};
  for (int i = 0; i < 12; ++i) {
    for (const int shift : {-60, 0, 600}) {
      EXPECT_EQ(WrapTexel(i + shift, 3, WrapMode::kRepeat), repeat[size_t(i)]);
      EXPECT_EQ(WrapTexel(i + shift, 3, WrapMode::kMirroredRepeat), mirror[size_t(i)]);
    }
    EXPECT_EQ(WrapTexel(i, 3, WrapMode::kClampToEdge), std::min(i, 2));
    EXPECT_EQ(WrapTexel(-i, 3, WrapMode::kClampToEdge), 0);
  }
}

TEST(TextureSampler, TexelCentresAndTheMiddleBetween) {
  const TextureImage image = Image(2, 1, [](int x, int) { return Gray(x * 255); });
  const MipPyramid pyramid(image, TextureEncoding::kSrgb);
  Texture repeat, clamp, nearest;
  clamp.wrap_s = WrapMode::kClampToEdge;
  nearest.nearest = true;
  EXPECT_EQ(Sample(pyramid, repeat, {0.25, 0.5}).x, 0);
  EXPECT_EQ(Sample(pyramid, repeat, {0.75, 0.5}).x, 1);
  EXPECT_EQ(Sample(pyramid, repeat, {0.5, 0.5}).x, 0.5f);
  EXPECT_EQ(Sample(pyramid, repeat, {0.0, 0.5}).x, 0.5f);  // Wraps around to the white texel.
  EXPECT_EQ(Sample(pyramid, clamp, {0.0, 0.5}).x, 0);
  EXPECT_EQ(Sample(pyramid, clamp, {7.0, 0.5}).x, 1);
  EXPECT_EQ(Sample(pyramid, nearest, {0.4999, 0.5}).x, 0);
  EXPECT_EQ(Sample(pyramid, nearest, {0.5001, 0.5}).x, 1);
  EXPECT_NEAR(Sample(pyramid, nearest, {0.5001, 0.5}, 1, 0).x, 0.5, 1e-4);  // Minified: filtered.
}

TEST(TextureSampler, NumbersThatAreNoneOrHuge) {
  const TextureImage image = Image(4, 4, [](int x, int y) { return Gray(16 * (x + 4 * y)); });
  const MipPyramid pyramid(image, TextureEncoding::kSrgb);
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -infinity, 1e300, -1e300}) {
    for (const double footprint : {0.0, 1.0, nan, infinity}) {
      const V4f c = Sample(pyramid, {}, {bad, bad}, footprint, footprint);
      EXPECT_GE(c.x, 0);
      EXPECT_LE(c.x, 1);
    }
  }
}

TEST(MipPyramidCache, SharesAndForgets) {
  const std::vector<TextureImage> images{Image(4, 4, [](int, int) { return Gray(9); })};
  const MipPyramidCache cache;
  const auto pyramid = cache.Get(images, 0, TextureEncoding::kSrgb);
  EXPECT_EQ(cache.Get(images, 0, TextureEncoding::kSrgb), pyramid);
  const MipPyramidCache copy = cache;
  EXPECT_NE(copy.Get(images, 0, TextureEncoding::kSrgb), pyramid);
}

}  // namespace
}  // namespace shutterline::engine
