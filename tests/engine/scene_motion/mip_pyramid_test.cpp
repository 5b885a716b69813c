#include "worker/engine/scene/mip_pyramid.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "worker/engine/scene/scene.h"

namespace shutterline::engine::mip_pyramid_test {
namespace {

using Texels = std::vector<std::array<uint16_t, 4>>;

TextureImage Image(int width, int height, int bits, const Texels& texels) {
  TextureImage image;
  image.width = width;
  image.height = height;
  for (const auto& texel : texels) {
    for (const uint16_t code : texel) {
      if (bits == 16) {
        image.rgba16.push_back(code);
      } else {
        image.rgba.push_back(uint8_t(code));
      }
    }
  }
  return image;
}

void ExpectTexel(const V4f& texel, const V4f& expected, float tolerance) {
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(texel[i], expected[i], tolerance) << "channel " << i;
}

TEST(MipPyramid, DecodesColoursByTheirEncodingAndAlphaNever) {
  const TextureImage image8 = Image(1, 1, 8, {{188, 10, 255, 51}});
  ExpectTexel(MipPyramid(image8, TextureEncoding::kLinear).Texel(0, 0, 0),
              V4f(188 / 255.f, 10 / 255.f, 1, 0.2f), 0);
  ExpectTexel(MipPyramid(image8, TextureEncoding::kSrgb).Texel(0, 0, 0),
              V4f(LinearFromSrgb8(188), 10 / 255.f / 12.92f, 1, 0.2f), 1e-7f);
  const TextureImage image16 = Image(1, 1, 16, {{48192, 2000, 65535, 13107}});
  ExpectTexel(MipPyramid(image16, TextureEncoding::kLinear).Texel(0, 0, 0),
              V4f(48192 / 65535.f, 2000 / 65535.f, 1, 0.2f), 0);
  // Half of full radiance has the code 0.73536 of full.
  ExpectTexel(MipPyramid(image16, TextureEncoding::kSrgb).Texel(0, 0, 0),
              V4f(0.5f, 2000 / 65535.f / 12.92f, 1, 0.2f), 2e-5f);
}

TEST(MipPyramid, SixteenBitCodesContinueThoseOfEight) {
  for (int code = 0; code < 256; ++code) {
    EXPECT_EQ(LinearFromSrgb16(uint16_t(257 * code)), LinearFromSrgb8(uint8_t(code))) << code;
    if (code == 0) continue;
    EXPECT_GT(LinearFromSrgb16(uint16_t(257 * code)), LinearFromSrgb16(uint16_t(257 * code - 1)));
  }
}

TEST(MipPyramid, AveragesChannelsByThemselves) {
  // Colour under transparent texels counts as much as any other.
  const Texels texels = {{255, 0, 100, 0}, {0, 0, 100, 255}, {0, 255, 100, 255}, {0, 0, 100, 255}};
  for (const int bits : {8, 16}) {
    Texels codes = texels;
    for (auto& texel : codes) {
      for (uint16_t& code : texel) code = uint16_t(bits == 16 ? 257 * code : code);
    }
    const TextureImage image = Image(2, 2, bits, codes);
    for (const TextureEncoding encoding : {TextureEncoding::kSrgb, TextureEncoding::kLinear}) {
      const MipPyramid pyramid(image, encoding);
      ASSERT_EQ(pyramid.level_count(), 2);
      const float blue = encoding == TextureEncoding::kSrgb ? LinearFromSrgb8(100) : 100 / 255.f;
      ExpectTexel(pyramid.Texel(1, 0, 0), V4f(0.25f, 0.25f, blue, 0.75f), 1.01f / 65535);
    }
  }
}

TEST(MipPyramid, EveryLevelKeepsTheMeanOfEveryChannel) {
  std::mt19937 random(11);
  for (const auto& [width, height] : {std::pair(7, 5), std::pair(64, 3), std::pair(1, 9)}) {
    Texels texels(size_t(width) * size_t(height));
    for (auto& texel : texels) {
      for (uint16_t& code : texel) code = uint16_t(random());
    }
    const TextureImage image = Image(width, height, 16, texels);
    for (const TextureEncoding encoding : {TextureEncoding::kSrgb, TextureEncoding::kLinear}) {
      const MipPyramid pyramid(image, encoding);
      const auto mean = [&](int level) {
        V4d sum(0);
        for (int y = 0; y < pyramid.Height(level); ++y) {
          for (int x = 0; x < pyramid.Width(level); ++x) sum += V4d(pyramid.Texel(level, x, y));
        }
        return sum / double(pyramid.Width(level) * pyramid.Height(level));
      };
      const V4d first = mean(0);
      for (int level = 1; level < pyramid.level_count(); ++level) {
        for (int c = 0; c < 4; ++c) EXPECT_NEAR(mean(level)[c], first[c], 5e-5) << "level " << level;
      }
    }
  }
}

TEST(MipPyramidCache, KeepsOneAnImageAndEncoding) {
  const std::vector<TextureImage> images = {Image(1, 1, 8, {{1, 2, 3, 4}}), Image(1, 1, 8, {{5, 6, 7, 8}})};
  const MipPyramidCache cache;
  const auto srgb = cache.Get(images, 0, TextureEncoding::kSrgb);
  const auto linear = cache.Get(images, 0, TextureEncoding::kLinear);
  EXPECT_NE(srgb, linear);
  EXPECT_NE(cache.Get(images, 1, TextureEncoding::kLinear), linear);
  EXPECT_EQ(cache.Get(images, 0, TextureEncoding::kSrgb), srgb);
  EXPECT_EQ(cache.Get(images, 0, TextureEncoding::kLinear), linear);
  EXPECT_EQ(linear->Texel(0, 0, 0).x, 1 / 255.f);
  EXPECT_NE(srgb->Texel(0, 0, 0).x, 1 / 255.f);
}

}  // namespace
}  // namespace shutterline::engine::mip_pyramid_test
