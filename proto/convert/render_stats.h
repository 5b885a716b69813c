#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include "common/job/render_stats.h"
#include "shutterline/v1/types.pb.h"

/// Statistics to and from the wire, field by field of the tables in common/job/render_stats.h.
namespace shutterline::convert {

v1::RenderStats ToProto(const RenderStats& stats);
/// INVALID_ARGUMENT with the field's name ("stats.lines: ...") where a count is negative or seconds are
/// negative, not finite or above kMaxStatsSeconds. `field` is the message's name in its parent.
absl::StatusOr<RenderStats> FromProto(const v1::RenderStats& message, absl::string_view field);

}  // namespace shutterline::convert
