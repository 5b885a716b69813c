#include "common/image/png.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "tests/common/image/random_image.h"

namespace shutterline {
namespace {

/// Every code is the nearest to the values that the sRGB definition gives it, decided by the definition's
/// inverse at the borders between codes.
TEST(Png, SrgbCodesAreTheNearest) {
  for (int code = 0; code < 255; ++code) {
    const double border = (code + 0.5) / 255;
    const double linear = border <= 0.04045 ? border / 12.92 : std::pow((border + 0.055) / 1.055, 2.4);
    EXPECT_EQ(SrgbByte(float(linear * (1 - 1e-4))), code);
    EXPECT_EQ(SrgbByte(float(linear * (1 + 1e-4))), code + 1);
  }
}

TEST(Png, ClampsAndRemovesNaN) {
  EXPECT_EQ(SrgbByte(-1), 0);
  EXPECT_EQ(SrgbByte(std::nanf("")), 0);
  EXPECT_EQ(SrgbByte(-std::numeric_limits<float>::infinity()), 0);
  EXPECT_EQ(SrgbByte(std::numeric_limits<float>::infinity()), 255);
  EXPECT_EQ(SrgbByte(1), 255);
  EXPECT_EQ(SrgbByte(1e-30f), 0);
}

TEST(Png, RoundTripThroughTheDecoder) {
  for (const auto& [width, height] : {std::pair{1, 1}, {33, 31}}) {
    const Image image = RandomImage(width, height, 9, -0.2f, 1.2f);
    const auto bytes = EncodePng(image);
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    png_image decoder;
    std::memset(&decoder, 0, sizeof decoder);
    decoder.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_memory(&decoder, bytes->data(), bytes->size()));
    EXPECT_EQ(int(decoder.width), width);
    EXPECT_EQ(int(decoder.height), height);
    EXPECT_EQ(decoder.format, unsigned(PNG_FORMAT_RGB));
    decoder.format = PNG_FORMAT_RGB;
    std::vector<uint8_t> pixels(PNG_IMAGE_SIZE(decoder));
    ASSERT_TRUE(png_image_finish_read(&decoder, nullptr, pixels.data(), 0, nullptr));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < 3; ++c) {
          ASSERT_EQ(pixels[size_t((y * width + x) * 3 + c)], SrgbByte(image.At(x, y)[c]));
        }
      }
    }
  }
}

TEST(Png, RefusesWhatItCannotShow) {
  EXPECT_FALSE(EncodePng(Image()).ok());
  EXPECT_FALSE(EncodePng(Image(2, 2, {"X", "Y"})).ok());
  EXPECT_TRUE(EncodePng(Image(2, 2, {"Z"})).ok());
  EXPECT_EQ(WritePng("/nonexistent/a.png", Image(2, 2)).code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace shutterline
