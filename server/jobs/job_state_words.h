#pragma once

#include <absl/strings/string_view.h>

#include <array>

#include "server/jobs/job_store.h"

namespace shutterline::server {

inline constexpr std::array kJobStates = {JobState::kQueued, JobState::kRunning,   JobState::kSucceeded,
                                          JobState::kFailed, JobState::kCancelled, JobState::kPartial};

/// The word for a state in logs, metrics and JSON; never renamed.
inline absl::string_view JobStateWord(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return "queued";
    case JobState::kRunning:
      return "running";
    case JobState::kSucceeded:
      return "succeeded";
    case JobState::kFailed:
      return "failed";
    case JobState::kCancelled:
      return "cancelled";
    case JobState::kPartial:
      return "partial";
  }
  return "unknown";
}

}  // namespace shutterline::server
