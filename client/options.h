#pragma once

#include <absl/status/status.h>

#include <optional>
#include <string>

#include "client/command_line.h"
#include "client/output_path.h"
#include "client/progress.h"
#include "common/job/job_spec.h"
#include "common/job/render_settings.h"

namespace shutterline::client {

/// What `render` and `submit` are told on the command line.
struct JobOptions {
  std::string scene;        ///< Path of the .gltf or .glb file.
  std::string environment;  ///< Path of an EXR that lights the scene; empty: none.
  FrameRange frames{1, 1, 1};
  RenderSettings settings;
  OutputSettings output_settings;
  TileOrder order = TileOrder::kHilbert;
  std::optional<OutputPath> output;
  bool png = false;  ///< Also write an 8-bit sRGB preview beside each EXR.

  bool shutter_close_given = false;
  bool target_error_given = false, time_step_given = false;
  bool half_given = false, float_given = false;
};

/// The positional SCENE: the path of a .gltf or .glb file.
void AddSceneArgument(CLI::App& app, std::string& scene);

/// Declares the options that `render` and `submit` share. Defaults are those of RenderSettings.
void AddJobOptions(CLI::App& app, JobOptions& options);
/// What only the options together can break: INVALID_ARGUMENT naming the options.
absl::Status CheckJobOptions(JobOptions& options);

/// -o alone.
void AddOutputOption(CLI::App& app, std::optional<OutputPath>& output, const std::string& description);

/// --json and --quiet, where a command has them.
void AddJsonOption(CLI::App& app, bool& json);
void AddQuietOption(CLI::App& app, bool& quiet);

/// --stats, where a command knows finished frames.
void AddStatsOption(CLI::App& app, bool& stats);

/// A bar where errors go to a terminal, lines where they do not.
ProgressStyle ChooseStyle(const Console& console, bool quiet);

/// The positional JOB: a UUID as `submit` prints it.
void AddJobArgument(CLI::App& app, std::string& job);

}  // namespace shutterline::client
