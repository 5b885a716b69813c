#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <string>

#include "client/command_line.h"
#include "client/delivery.h"
#include "client/upload.h"

namespace shutterline::client {

struct ReportOptions {
  bool json = false, quiet = false;
  /// Also what rendering the frames took, by this method (as DescribeSettings); `quiet` does not silence it.
  std::optional<std::string> stats_of;
};

/// Prints what a job delivered (as JSON, or a line per file) and, where the job did not succeed, an error
/// line; returns the process's exit code. INVALID_ARGUMENT where the coordinator's statistics cannot be.
absl::StatusOr<ExitCode> Report(Console& console, const Delivery& delivery, const UploadReport& upload,
                                const ReportOptions& options);

}  // namespace shutterline::client
