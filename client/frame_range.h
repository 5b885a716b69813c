#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>

#include "common/job/job_spec.h"

namespace shutterline::client {

/// Frame numbers lie within ±kMaxFrameNumber; a range has at most JobLimits().max_frames of them.
inline constexpr int64_t kMaxFrameNumber = 1'000'000;

/// "A-B" or "A-BxS" with A <= B and S >= 1; numbers may be negative ("-3--1"). "7" alone is one frame.
/// Errors are INVALID_ARGUMENT and say what is allowed.
absl::StatusOr<FrameRange> ParseFrameRange(absl::string_view text);
/// One frame's number.
absl::StatusOr<FrameRange> ParseFrame(absl::string_view text);

}  // namespace shutterline::client
