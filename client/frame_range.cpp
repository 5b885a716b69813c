#include "client/frame_range.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include "client/parse.h"
#include "common/base/status_macros.h"

namespace shutterline::client {

absl::StatusOr<FrameRange> ParseFrame(absl::string_view text) {
  SL_ASSIGN_OR_RETURN(const int64_t frame, ParseWhole(text, -kMaxFrameNumber, kMaxFrameNumber));
  return FrameRange{static_cast<int>(frame), static_cast<int>(frame), 1};
}

absl::StatusOr<FrameRange> ParseFrameRange(absl::string_view text) {
  FrameRange range;
  // Split off the step: frames are numbers and dashes, so the first x starts it.
  const size_t cross = text.find('x');
  absl::string_view ends = text.substr(0, cross);
  if (cross != absl::string_view::npos) {
    const auto step = ParseWhole(text.substr(cross + 1), 1, 2 * kMaxFrameNumber);
    if (!step.ok()) return Annotate(step.status(), "the step after x");
    range.step = static_cast<int>(*step);
  }
  if (ends.empty()) return absl::InvalidArgumentError("must be A-B or A-BxS, as in 1-48 or 1-48x2");

  // Split at the first dash that is not the sign of A.
  const size_t dash = ends.find('-', 1);
  const auto first = ParseWhole(ends.substr(0, dash), -kMaxFrameNumber, kMaxFrameNumber);
  if (!first.ok()) return Annotate(first.status(), "the first frame");
  range.first = range.last = static_cast<int>(*first);
  if (dash != absl::string_view::npos) {
    const auto last = ParseWhole(ends.substr(dash + 1), -kMaxFrameNumber, kMaxFrameNumber);
    if (!last.ok()) return Annotate(last.status(), "the last frame");
    range.last = static_cast<int>(*last);
  }
  if (range.last < range.first) {
    return absl::InvalidArgumentError(
        absl::StrCat("the last frame (", range.last, ") must not come before the first (", range.first, ")"));
  }
  const int64_t most = JobLimits().max_frames;
  if (range.Count() > most) {
    return absl::InvalidArgumentError(
        absl::StrCat("has ", range.Count(), " frames, but must have at most ", most));
  }
  return range;
}

}  // namespace shutterline::client
