#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <array>
#include <cstdint>
#include <vector>

#include "common/job/render_settings.h"

namespace shutterline::client {

/// Numbers as people type them, read strictly: the whole text must be the number, without spaces, plus
/// signs, hexadecimal digits, "nan" or "inf". Errors are INVALID_ARGUMENT and say what is allowed ("must
/// be a whole number from 1 to 32768"); the caller adds the option and the text.
absl::StatusOr<int64_t> ParseWhole(absl::string_view text, int64_t least, int64_t most);
absl::StatusOr<uint64_t> ParseUnsigned(absl::string_view text);
/// A decimal number from `least` to `most`, both finite and included. `allowed` describes the range.
absl::StatusOr<double> ParseReal(absl::string_view text, double least, double most,
                                 absl::string_view allowed);

/// Width and height in pixels, "1024x768".
struct FrameSize {
  int width = 0, height = 0;
};
absl::StatusOr<FrameSize> ParseFrameSize(absl::string_view text);

/// A shutter's opening over its time: box (nothing), triangle, trapezoid, decay (exponential, to a
/// twentieth), or points "0:0,0.25:1,1:0".
absl::StatusOr<std::vector<ShutterPoint>> ParseShutterCurve(absl::string_view text);

/// Red, green and blue, "0.5,0.5,1", each from 0 to `most`.
absl::StatusOr<std::array<double, 3>> ParseColor(absl::string_view text, double most);

}  // namespace shutterline::client
