#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "client/json_output.h"
#include "common/job/render_stats.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::client {

/// What rendering a frame, or several, took.
struct FrameStats {
  RenderStats stats;        ///< stats.tiles < tiles_total: the others were not measured.
  int64_t tiles_total = 0;  ///< Of the frame's grid.
  uint64_t file_bytes = 0;  ///< Of the EXR.

  FrameStats& operator+=(const FrameStats& other);
};

/// What rendering a job's finished frames took: what `--stats` prints.
struct StatsReport {
  std::string method;  ///< As DescribeSettings.
  std::map<int, FrameStats> frames;

  FrameStats Total() const;
};

/// INVALID_ARGUMENT, naming frame and field, where the coordinator says what cannot be.
absl::StatusOr<StatsReport> MakeStatsReport(std::string method, const std::map<int, v1::FrameStatus>& frames);

/// Every field of RenderStats by its name and what follows from them; a ratio to nothing is null.
Json ToJson(const FrameStats& stats);
/// {"method", "frames": [...], "total"}.
Json ToJson(const StatsReport& report);

/// A table of a line a frame, then every figure of all frames together.
void PrintStats(const StatsReport& report, std::ostream& out);

}  // namespace shutterline::client
