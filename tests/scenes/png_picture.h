#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace shutterline::scenes {

/// A picture as a PNG holds it: codes, not colours.
struct PngPicture {
  int width = 0, height = 0;
  int channels = 4;               ///< 1: grey, 2: grey and alpha, 3: RGB, 4: RGB and alpha.
  int bits = 8;                   ///< 8 or 16 a sample.
  std::vector<uint16_t> samples;  ///< Interleaved, rows from the top.
};

/// The bytes of a PNG file without any statement about colour. Equal pictures give equal bytes. Counts that
/// do not agree are our own defect: SL_CHECK.
std::string EncodePng(const PngPicture& picture);

}  // namespace shutterline::scenes
