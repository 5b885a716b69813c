#include <absl/strings/str_cat.h>

#include <cmath>

#include "common/base/build_id.h"
#include "common/base/status_macros.h"
#include "tests/bench/csv.h"
#include "tests/bench/machine.h"
#include "tests/bench/speed_vs_error.h"

namespace shutterline::bench {
namespace {

const std::vector<std::string> kCsvColumns = {"commit",
                                              "machine",
                                              "threads",
                                              "clock",
                                              "scene",
                                              "triangles",
                                              "frame",
                                              "width",
                                              "height",
                                              "fps",
                                              "shutter_open",
                                              "shutter_close",
                                              "tiles",
                                              "tiles_in_frame",
                                              "import_s",
                                              "reference_spp",
                                              "reference_noise",
                                              "contender",
                                              "rung",
                                              "is_default",
                                              "integrator",
                                              "resolver",
                                              "pattern",
                                              "time_step",
                                              "time_samples",
                                              "spp",
                                              "runs",
                                              "pose_s",
                                              "build_s",
                                              "build_cpu_s",
                                              "tiles_s",
                                              "tiles_min_s",
                                              "tiles_max_s",
                                              "tiles_cpu_s",
                                              "frame_s",
                                              "frame_cpu_s",
                                              "d",
                                              "d_se",
                                              "rmse",
                                              "below_floor",
                                              "d_moving",
                                              "d_moving_se",
                                              "rmse_moving",
                                              "rmse_static_edges",
                                              "rmse_disocclusions",
                                              "bias_squared",
                                              "relative_mse",
                                              "psnr",
                                              "flip_ldr",
                                              "flip_hdr",
                                              "flip_ldr_floor",
                                              "flip_hdr_floor",
                                              "share_moving",
                                              "share_static_edges",
                                              "share_disocclusions",
                                              "candidates",
                                              "lines",
                                              "instants",
                                              "segments",
                                              "spans",
                                              "pairs",
                                              "cull_s",
                                              "setup_s",
                                              "resolve_s",
                                              "shade_s"};

std::string RmseCell(const UnbiasedError& error) {
  if (error.pixels == 0) return "";
  return error.BelowFloor() ? "below floor" : Cell(error.Rmse());
}

std::vector<std::string> RowOf(const SceneResult& scene, const RunRow& run, const ReportOptions& options) {
  const RenderSettings& s = run.settings;
  const Measurement& m = run.measurement;
  const ErrorFigures& e = run.errors;
  const engine::RenderStats& stats = m.stats;
  const bool line = s.integrator == IntegratorKind::kLine;
  const auto word = [](absl::string_view text) { return std::string(text); };
  const auto count = [](int64_t value) { return Cell(value); };
  return {kBuildId,
          MachineName(),
          count(options.threads),
          options.cpu_clock ? "cpu" : "wall",
          scene.scene.name,
          count(scene.triangles),
          count(scene.scene.frame),
          count(s.width),
          count(s.height),
          Cell(s.fps),
          Cell(s.shutter_open),
          Cell(s.shutter_close),
          count(scene.tiles),
          count(scene.tiles_in_frame),
          Cell(scene.import_seconds),
          count(scene.reference.spp),
          Cell(scene.reference.noise),
          run.contender,
          run.rung,
          run.is_default ? "1" : "0",
          word(ToString(s.integrator)),
          line ? word(ToString(s.resolver)) : "",
          line ? word(ToString(s.pattern)) : "",
          line ? Cell(s.time_step) : "",
          line && s.time_samples ? count(*s.time_samples) : "",
          line ? "" : count(s.spp),
          count(m.runs),
          Cell(m.pose_wall),
          Cell(m.build_wall),
          Cell(m.build_cpu),
          Cell(m.tiles_wall),
          Cell(m.tiles_wall_min),
          Cell(m.tiles_wall_max),
          Cell(m.tiles_cpu),
          Cell(m.FrameWall()),
          Cell(m.FrameCpu()),
          Cell(e.whole.d),
          Cell(e.whole.standard_error),
          RmseCell(e.whole),
          e.whole.BelowFloor() ? "1" : "0",
          Cell(e.moving.d),
          Cell(e.moving.standard_error),
          RmseCell(e.moving),
          RmseCell(e.static_edges),
          RmseCell(e.disocclusions),
          Cell(e.bias_squared),
          Cell(e.relative_mse),
          Cell(e.psnr),
          Cell(e.flip_ldr),
          Cell(e.flip_hdr),
          Cell(scene.flip_floor.ldr),
          Cell(scene.flip_floor.hdr),
          Cell(scene.moving),
          Cell(scene.static_edges),
          Cell(scene.disocclusions),
          count(stats.candidate_triangles),
          count(stats.lines),
          count(stats.instants),
          count(stats.segments),
          count(stats.spans),
          count(stats.pairs),
          Cell(stats.cull_seconds),
          Cell(stats.setup_seconds),
          Cell(stats.resolve_seconds),
          Cell(stats.shade_seconds)};
}

}  // namespace

absl::Status WriteSpeedCsv(const std::vector<SceneResult>& results, const ReportOptions& options) {
  CsvTable table(kCsvColumns);
  for (const SceneResult& scene : results) {
    for (const RunRow& run : scene.runs) table.AddRow(RowOf(scene, run, options));
  }
  SL_ASSIGN_OR_RETURN(const std::string path, OutputPath(options, "speed_vs_error.csv"));
  return table.Write(path);
}

}  // namespace shutterline::bench
