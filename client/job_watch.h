#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>

#include "client/connection.h"

namespace shutterline::client {

using OnJobEvent = std::function<absl::Status(const v1::JobEvent&)>;

/// Follows a job until it has ended and returns how it ended (without its specification). Each event goes
/// to `on_event` once, in order; an error from it ends the watch. A dropped connection is taken up again
/// after the last event seen, for as long as the connection's watch patience lasts.
absl::StatusOr<v1::Job> WatchJob(Connection& connection, const std::string& job_id,
                                 const OnJobEvent& on_event);

bool HasEnded(v1::JobState state);

}  // namespace shutterline::client
