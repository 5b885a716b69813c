#include "client/parse.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <charconv>
#include <cmath>
#include <string>
#include <system_error>

#include "common/base/status_macros.h"
#include "common/job/render_settings.h"

namespace shutterline::client {
namespace {

/// std::from_chars over all of `text`: it knows neither spaces, nor plus signs, nor locales.
template <typename Number>
bool ReadAll(absl::string_view text, Number& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end && !text.empty();
}

}  // namespace

absl::StatusOr<int64_t> ParseWhole(absl::string_view text, int64_t least, int64_t most) {
  int64_t value = 0;
  if (!ReadAll(text, value) || value < least || value > most) {
    return absl::InvalidArgumentError(absl::StrCat("must be a whole number from ", least, " to ", most));
  }
  return value;
}

absl::StatusOr<uint64_t> ParseUnsigned(absl::string_view text) {
  uint64_t value = 0;
  if (!ReadAll(text, value)) {
    return absl::InvalidArgumentError("must be a whole number from 0 to 18446744073709551615");
  }
  return value;
}

absl::StatusOr<double> ParseReal(absl::string_view text, double least, double most,
                                 absl::string_view allowed) {
  double value = 0;
  // from_chars accepts the words "nan" and "inf": neither passes the comparison.
  if (!ReadAll(text, value) || !(value >= least && value <= most)) {
    return absl::InvalidArgumentError(absl::StrCat("must be ", allowed));
  }
  return value;
}

absl::StatusOr<FrameSize> ParseFrameSize(absl::string_view text) {
  const size_t cross = text.find('x');
  if (cross == absl::string_view::npos) {
    return absl::InvalidArgumentError("must be WIDTHxHEIGHT in pixels, as in 1024x768");
  }
  const auto width = ParseWhole(text.substr(0, cross), 1, kMaxFrameSide);
  if (!width.ok()) return Annotate(width.status(), "width");
  const auto height = ParseWhole(text.substr(cross + 1), 1, kMaxFrameSide);
  if (!height.ok()) return Annotate(height.status(), "height");
  return FrameSize{static_cast<int>(*width), static_cast<int>(*height)};
}

absl::StatusOr<std::vector<ShutterPoint>> ParseShutterCurve(absl::string_view text) {
  std::vector<ShutterPoint> points;
  if (text == "box") return points;
  if (text == "triangle") return std::vector<ShutterPoint>{{0, 0}, {0.5, 1}, {1, 0}};
  if (text == "trapezoid") return std::vector<ShutterPoint>{{0, 0}, {0.25, 1}, {0.75, 1}, {1, 0}};
  if (text == "decay") {
    constexpr int kPieces = 16;
    for (int i = 0; i <= kPieces; ++i) points.push_back({i / double(kPieces), std::exp(-3.0 * i / kPieces)});
    return points;
  }
  for (const absl::string_view point : absl::StrSplit(text, ',')) {
    const size_t colon = point.find(':');
    if (colon == absl::string_view::npos) {
      return absl::InvalidArgumentError(
          "must be box, triangle, trapezoid, decay, or points as in 0:0,0.25:1,1:0");
    }
    ShutterPoint& p = points.emplace_back();
    SL_ASSIGN_OR_RETURN(p.time,
                        ParseReal(point.substr(0, colon), 0, 1, "a time from 0 to 1, before the colon"));
    SL_ASSIGN_OR_RETURN(p.opening, ParseReal(point.substr(colon + 1), 0, kMaxShutterOpening,
                                             absl::StrCat("an opening from 0 to ", kMaxShutterOpening)));
  }
  return points;
}

absl::StatusOr<std::array<double, 3>> ParseColor(absl::string_view text, double most) {
  const std::string allowed = absl::StrCat("three numbers R,G,B from 0 to ", most, ", as in 0.5,0.5,1");
  std::array<double, 3> color{};
  for (size_t c = 0; c < 3; ++c) {
    const size_t comma = text.find(',');
    if ((comma == absl::string_view::npos) != (c == 2)) {
      return absl::InvalidArgumentError(absl::StrCat("must be ", allowed));
    }
    const absl::StatusOr<double> value = ParseReal(text.substr(0, comma), 0, most, allowed);
    if (!value.ok()) return value.status();
    color[c] = *value;
    if (c < 2) text.remove_prefix(comma + 1);
  }
  return color;
}

}  // namespace shutterline::client
