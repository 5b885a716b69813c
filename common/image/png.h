#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

#include "common/image/image.h"

namespace shutterline {

/// The sRGB code, 0 to 255, of a linear value: clamped to [0, 1] and rounded to the nearest; NaN is 0.
uint8_t SrgbByte(float linear);

/// A preview for people: an opaque 8-bit sRGB PNG of the channels R, G and B over black. Colours are
/// premultiplied, so "over black" means that alpha is left out. No tone mapping: what is brighter than 1
/// is white. An image with a single channel becomes grey. INVALID_ARGUMENT for an image that is empty or
/// has other channels.
absl::StatusOr<std::string> EncodePng(const Image& image);

/// EncodePng into a file, atomically (see WriteFileAtomically).
absl::Status WritePng(const std::string& path, const Image& image);

}  // namespace shutterline
