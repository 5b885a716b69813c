#pragma once

#include <absl/status/statusor.h>

#include <map>
#include <string>
#include <vector>

#include "client/command_line.h"
#include "client/connection.h"
#include "client/frame_fetch.h"
#include "client/output_path.h"
#include "client/progress.h"
#include "common/job/job_spec.h"

namespace shutterline::client {

/// What a job's watcher has in hand when the job has ended.
struct Delivery {
  v1::Job job;                              ///< How it ended; without its specification.
  std::vector<FetchedFrame> frames;         ///< In the order in which they were written.
  std::map<int, v1::FrameStatus> finished;  ///< How each finished frame stands, by its number.

  /// kSuccess where every frame is here whole, kPartial where some are, or lack tiles, kFailed where none is.
  ExitCode Code() const;
};

/// Where frames are to go.
struct Destination {
  OutputPath output;
  bool png = false;
};

/// OK if the folder of `output` exists and may be written to: asked before hours of rendering, not after.
absl::Status CheckDestination(const OutputPath& output);

/// Watches a job to its end, shows its progress and, where `destination` is not null, fetches each frame
/// of `frames` as it is finished. A job that fails or is cancelled is no error here: see Delivery::Code.
absl::StatusOr<Delivery> Deliver(Connection& connection, const std::string& job_id, const FrameRange& frames,
                                 const Destination* destination, Progress& progress);

/// "failed: tile 12 of frame 3 ...": how a job that did not succeed ended, for an error message.
std::string DescribeEnd(const v1::Job& job);

/// What Progress draws, from a job's state and counts.
ProgressFacts FactsOf(const v1::Job& job);

/// "queued", "running", "succeeded", "failed", "cancelled", "partial"; "unknown" for what a later server may
/// say.
std::string WordOf(v1::JobState state);

}  // namespace shutterline::client
