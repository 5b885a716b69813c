#include "common/image/png.h"

#include <absl/strings/str_cat.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <vector>

#include "common/base/atomic_file.h"
#include "common/base/status_macros.h"
#include "common/job/render_settings.h"

namespace shutterline {
namespace {

/// All that the encoder owns; it lives outside the frame that libpng may jump out of.
struct Encoding {
  std::string bytes;
  std::vector<uint8_t> row;
  std::array<char, 256> message{};
  png_structp png = nullptr;
  png_infop info = nullptr;

  ~Encoding() { png_destroy_write_struct(&png, &info); }
};

[[noreturn]] void OnError(png_structp png, png_const_charp message) {
  auto* encoding = static_cast<Encoding*>(png_get_error_ptr(png));
  std::strncpy(encoding->message.data(), message, encoding->message.size() - 1);
  png_longjmp(png, 1);
}

void OnWarning(png_structp, png_const_charp) {}

void OnWrite(png_structp png, png_bytep data, png_size_t size) {
  bool stored = false;
  try {
    static_cast<Encoding*>(png_get_io_ptr(png))->bytes.append(reinterpret_cast<const char*>(data), size);
    stored = true;
  } catch (...) {
    // Exceptions must not pass through C; png_error jumps, so it is called outside the handler.
  }
  if (!stored) png_error(png, "out of memory");
}

void OnFlush(png_structp) {}

/// Returns false with `message` set. Nothing in this function has a destructor: libpng reports errors by
/// a jump back to setjmp, which would skip it.
bool Encode(const Image& image, const std::array<int, 3>& channels, Encoding& encoding) {
  encoding.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &encoding, OnError, OnWarning);
  if (encoding.png == nullptr) return false;
  if (setjmp(png_jmpbuf(encoding.png)) != 0) return false;
  encoding.info = png_create_info_struct(encoding.png);
  if (encoding.info == nullptr) return false;
  png_set_write_fn(encoding.png, &encoding, OnWrite, OnFlush);
  png_set_IHDR(encoding.png, encoding.info, png_uint_32(image.width()), png_uint_32(image.height()), 8,
               PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB_gAMA_and_cHRM(encoding.png, encoding.info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(encoding.png, encoding.info);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const float* pixel = image.At(x, y);
      for (size_t c = 0; c < 3; ++c) encoding.row[size_t(x) * 3 + c] = SrgbByte(pixel[channels[c]]);
    }
    png_write_row(encoding.png, encoding.row.data());
  }
  png_write_end(encoding.png, nullptr);
  return true;
}

absl::StatusOr<std::array<int, 3>> ColourChannels(const Image& image) {
  const std::vector<std::string>& names = image.channels();
  if (names.size() == 1) return std::array<int, 3>{0, 0, 0};
  std::array<int, 3> result{};
  for (size_t c = 0; c < 3; ++c) {
    const char* wanted = std::array<const char*, 3>{"R", "G", "B"}[c];
    const auto found = std::find(names.begin(), names.end(), wanted);
    if (found == names.end()) {
      return absl::InvalidArgumentError(absl::StrCat("encode PNG: the image has no channel ", wanted));
    }
    result[c] = int(found - names.begin());
  }
  return result;
}

}  // namespace

uint8_t SrgbByte(float linear) {
  if (!(linear > 0)) return 0;  // NaN too.
  if (linear >= 1) return 255;
  const float encoded = linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
  return uint8_t(std::clamp(encoded * 255 + 0.5f, 0.0f, 255.0f));
}

absl::StatusOr<std::string> EncodePng(const Image& image) {
  if (image.width() < 1 || image.height() < 1 || image.width() > kMaxFrameSide ||
      image.height() > kMaxFrameSide) {
    return absl::InvalidArgumentError(
        absl::StrCat("encode PNG: an image of ", image.width(), " × ", image.height(), " pixels"));
  }
  SL_ASSIGN_OR_RETURN(const auto channels, ColourChannels(image));
  Encoding encoding;
  encoding.row.resize(size_t(image.width()) * 3);
  if (!Encode(image, channels, encoding)) {
    const char* reason = encoding.message[0] != '\0' ? encoding.message.data() : "out of memory";
    return absl::InternalError(absl::StrCat("encode PNG: ", reason));
  }
  return std::move(encoding.bytes);
}

absl::Status WritePng(const std::string& path, const Image& image) {
  absl::StatusOr<std::string> bytes = EncodePng(image);
  if (!bytes.ok()) return Annotate(bytes.status(), absl::StrCat("write ", path));
  return WriteFileAtomically(path, *bytes);
}

}  // namespace shutterline
