#pragma once

#include <absl/status/status.h>

#include "tests/bench/report.h"

/// The parts of the report: one function and one file a subcommand. Each prints what it measures as it goes
/// and writes a CSV, SVG plots and a page into the output folder.
namespace shutterline::bench {

absl::Status SpeedVsError(const ReportOptions& options);

}  // namespace shutterline::bench
