#include "tests/scenes/png_picture.h"

#include <png.h>

#include "common/base/check.h"

namespace shutterline::scenes {
namespace {

void Append(png_structp png, png_bytep bytes, png_size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

[[noreturn]] void Fail(png_structp, png_const_charp) {
  SL_CHECK(!"libpng refused the picture");
  std::abort();
}

}  // namespace

std::string EncodePng(const PngPicture& picture) {
  constexpr int kColorTypes[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                 PNG_COLOR_TYPE_RGB_ALPHA};
  SL_CHECK(picture.width > 0 && picture.height > 0 && picture.channels >= 1 && picture.channels <= 4);
  SL_CHECK(picture.bits == 8 || picture.bits == 16);
  const size_t in_row = size_t(picture.width) * size_t(picture.channels);
  SL_CHECK(picture.samples.size() == in_row * size_t(picture.height));

  std::string file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, &Fail, nullptr);
  SL_CHECK(png != nullptr);
  png_infop info = png_create_info_struct(png);
  SL_CHECK(info != nullptr);
  png_set_write_fn(png, &file, &Append, nullptr);
  png_set_IHDR(png, info, png_uint_32(picture.width), png_uint_32(picture.height), picture.bits,
               kColorTypes[picture.channels - 1], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  // Filters do the work on pictures full of noise; a longer search takes three times as long for little.
  png_set_compression_level(png, 2);
  png_write_info(png, info);
  std::string row;
  for (size_t y = 0; y < size_t(picture.height); ++y) {
    row.clear();
    for (size_t i = 0; i < in_row; ++i) {
      const uint16_t sample = picture.samples[y * in_row + i];
      if (picture.bits == 16) row.push_back(char(sample >> 8));  // Big-endian.
      row.push_back(char(sample & 255));
    }
    png_write_row(png, reinterpret_cast<png_const_bytep>(row.data()));
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return file;
}

}  // namespace shutterline::scenes
