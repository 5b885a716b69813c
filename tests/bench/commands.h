#pragma once

#include <absl/status/status.h>

#include "tests/bench/report.h"

/// The parts of the report: one function and one file a subcommand. Each prints what it measures as it goes
/// and writes a CSV, SVG plots and a page into the output folder.
namespace shutterline::bench {

absl::Status SpeedVsError(const ReportOptions& options);
/// Time and error against the length of motion, and a still against an open shutter where nothing moves.
absl::Status Motion(const ReportOptions& options);
/// Where the line integrator's time goes, scene by scene.
absl::Status Stages(const ReportOptions& options);
/// Errors of the depth of what single samples on lines see.
absl::Status DepthError(const ReportOptions& options);
/// Patterns of lines on a frame that stands still.
absl::Status Patterns(const ReportOptions& options);
/// Ambient occlusion: error and time of line samples and of rays, still and in motion.
absl::Status Occlusion(const ReportOptions& options);

/// Runs the default settings by this build and by the shutterline-bench of another, turn by turn, and prints
/// the ratio of their times and whether their pictures are equal.
absl::Status Against(const ReportOptions& options, const std::string& build_folder);
/// What Against asks of either build: one measurement of one rung, as a line of figures.
absl::Status MeasureOne(const ReportOptions& options, const std::string& scene, const std::string& contender,
                        int rung);

}  // namespace shutterline::bench
