#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/atomic_file.h"
#include "common/base/build_id.h"
#include "common/base/status_macros.h"
#include "tests/bench/commands.h"
#include "tests/bench/csv.h"
#include "tests/bench/html_page.h"
#include "tests/bench/machine.h"
#include "tests/bench/svg_plot.h"

namespace shutterline::bench {
namespace {

constexpr double kMotions[] = {0, 12, 25, 50, 100, 200};  // Pixels over the shutter.
const std::vector<std::string> kColumns = {
    "commit", "machine", "threads", "scene",       "triangles", "motion_pixels", "shutter", "method", "runs",
    "pose_s", "build_s", "tiles_s", "tiles_cpu_s", "frame_s",   "frame_cpu_s",   "d",       "d_se",   "rmse"};

/// A method as it is, whatever the motion.
struct Line {
  std::string label, color;
  bool random = false;
  std::function<void(RenderSettings&)> apply;
};

absl::StatusOr<std::vector<Line>> Lines(const ReportOptions& options) {
  ReportOptions whole = options;
  whole.quick = false;
  SL_ASSIGN_OR_RETURN(const std::vector<Contender> contenders, ChosenContenders(whole));
  std::vector<Line> lines;
  for (const Contender& contender : contenders) {
    if (contender.default_rung >= 0) {
      lines.push_back(
          {contender.name, contender.color, false, contender.ladder[size_t(contender.default_rung)].apply});
      continue;
    }
    for (const Rung& rung : contender.ladder) {
      if (rung.label != "64 spp") continue;
      lines.push_back({absl::StrCat(contender.name, ", ", rung.label), contender.color, true, rung.apply});
    }
  }
  const auto is_slice = [](const Contender& contender) { return contender.name == "line/slice"; };
  if (std::any_of(contenders.begin(), contenders.end(), is_slice)) {
    lines.push_back({"line/slice, 16 instants", PlotColors()[4], false, [](RenderSettings& s) {
                       s.integrator = IntegratorKind::kLine;
                       s.time_samples = 16;
                     }});
  }
  return lines;
}

/// The RMSE, or the largest that the reference allows where it cannot tell it from none.
double BoundOf(const UnbiasedError& e) {
  if (e.d >= 2 * e.standard_error) return e.Rmse();
  return std::sqrt(std::max(e.d, 0.0) + 2 * e.standard_error);
}

struct Point {
  Measurement measurement;
  UnbiasedError error;
};

absl::StatusOr<Point> MeasureLine(const LoadedScene& loaded, const RenderSettings& base, const Line& line,
                                  const TileSubset& subset, const ReferenceHalves& reference,
                                  const ReportOptions& options) {
  RenderSettings settings = base;
  line.apply(settings);
  Point point;
  SL_ASSIGN_OR_RETURN(point.measurement,
                      Measure(loaded.scene, 0, settings, subset,
                              {.threads = options.threads, .most_runs = 5, .new_seeds = line.random}));
  SL_ASSIGN_OR_RETURN(point.error,
                      MeasureUnbiasedError(point.measurement.pictures.front(), reference.a, reference.b));
  return point;
}

/// One scene at every length of motion: two plots.
absl::StatusOr<std::vector<std::string>> OneScene(const BenchScene& of, const ReportOptions& options,
                                                  CsvTable& table) {
  SL_ASSIGN_OR_RETURN(const std::vector<Line> lines, Lines(options));
  Plot time{.title = absl::StrCat(of.name, ": time"),
            .x = {"pixels of motion over the shutter", false},
            .y = {"seconds a frame", false}};
  Plot error{.title = absl::StrCat(of.name, ": error"), .x = time.x, .y = {"RMSE, linear", true}};
  for (const Line& line : lines) {
    time.series.push_back({.label = line.label, .color = line.color});
    error.series.push_back({.label = line.label, .color = line.color});
  }
  const TileSubset subset = StratifiedTiles(of.settings.width, of.settings.height, options.Side(), 5);
  for (const double motion : kMotions) {
    BenchScene scene = of;
    scene.options.motion_pixels = motion;
    SL_ASSIGN_OR_RETURN(const LoadedScene loaded, Load(scene));
    SL_ASSIGN_OR_RETURN(const auto frame_scene, engine::BuildFrameScene(loaded.scene, 0, scene.settings));
    SL_ASSIGN_OR_RETURN(const ReferenceHalves reference,
                        RenderReference(frame_scene, 0, scene.settings, subset, options.Spp(),
                                        options.threads, {options.cache}));
    for (size_t i = 0; i < lines.size(); ++i) {
      SL_ASSIGN_OR_RETURN(const Point point,
                          MeasureLine(loaded, scene.settings, lines[i], subset, reference, options));
      const Measurement& m = point.measurement;
      const double seconds = options.cpu_clock ? m.FrameCpu() / options.threads : m.FrameWall();
      std::printf("%-10s %5.0f px  %-24s %8.3f s  %s\n", of.name.c_str(), motion, lines[i].label.c_str(),
                  seconds, point.error.ToString().c_str());
      std::fflush(stdout);
      table.AddRow({kBuildId, MachineName(), Cell(int64_t{options.threads}), of.name,
                    Cell(int64_t(frame_scene->triangles.size())), Cell(motion), "open", lines[i].label,
                    Cell(int64_t{m.runs}), Cell(m.pose_wall), Cell(m.build_wall), Cell(m.tiles_wall),
                    Cell(m.tiles_cpu), Cell(m.FrameWall()), Cell(m.FrameCpu()), Cell(point.error.d),
                    Cell(point.error.standard_error), Cell(point.error.Rmse())});
      time.series[i].points.push_back({motion, seconds});
      error.series[i].points.push_back({motion, BoundOf(point.error)});
    }
  }
  for (Plot* plot : {&time, &error}) {
    for (PlotSeries& series : plot->series) series.line = series.points;
  }
  return std::vector<std::string>{RenderPlot(time), RenderPlot(error)};
}

/// The static scene with the shutter open against the same frame as a still; turn by turn.
absl::StatusOr<std::vector<std::string>> StillRow(const ReportOptions& options, CsvTable& table) {
  SL_ASSIGN_OR_RETURN(const auto scenes, BenchScenesNamed({"static"}));
  const BenchScene& scene = scenes.front();
  SL_ASSIGN_OR_RETURN(const LoadedScene loaded, Load(scene));
  const TileSubset subset = StratifiedTiles(scene.settings.width, scene.settings.height, 1, 5);
  double seconds[2] = {1e30, 1e30};
  bool equal = true;
  Image pictures[2];
  for (int round = 0; round < 5; ++round) {
    for (const int open : {0, 1}) {
      RenderSettings settings = scene.settings;
      if (open == 0) settings.shutter_close = settings.shutter_open;
      SL_ASSIGN_OR_RETURN(Measurement m, Measure(loaded.scene, 0, settings, subset,
                                                 {.threads = options.threads, .most_runs = 3}));
      // The least of many short runs: what disturbs them only adds.
      seconds[open] = std::min(seconds[open], m.tiles_cpu);
      pictures[open] = std::move(m.pictures.front());
      table.AddRow({kBuildId, MachineName(), Cell(int64_t{options.threads}), scene.name, "", "0",
                    open == 1 ? "open" : "still", "line/slice", Cell(int64_t{m.runs}), Cell(m.pose_wall),
                    Cell(m.build_wall), Cell(m.tiles_wall), Cell(m.tiles_cpu), Cell(m.FrameWall()),
                    Cell(m.FrameCpu()), "", "", ""});
    }
    equal = equal && pictures[0].values() == pictures[1].values();
  }
  const double ratio = seconds[1] / seconds[0];
  std::printf(
      "static     still %.4f s, shutter open %.4f s of CPU for all tiles: %.3f times; pictures are %s\n",
      seconds[0], seconds[1], ratio, equal ? "equal bits" : "different");
  return std::vector<std::string>{scene.name, absl::StrFormat("%.4f", seconds[0]),
                                  absl::StrFormat("%.4f", seconds[1]), absl::StrFormat("%.3f", ratio),
                                  equal ? "yes" : "no"};
}

}  // namespace

absl::Status Motion(const ReportOptions& options) {
  CsvTable table(kColumns);
  HtmlPage page("Time against motion");
  page.Paragraph(
      "The same scene moves farther and farther while the shutter is open; no option changes. After figure "
      "13 of "
      "Gribel et al. 2011.");
  const std::vector<std::string> names = options.scenes.empty()
                                             ? (options.quick ? std::vector<std::string>{"plane64"}
                                                              : std::vector<std::string>{"plane64", "trees"})
                                             : options.scenes;
  ReportOptions stated = options;  // Six lengths a scene: references of fewer points.
  stated.spp = options.Spp() / 4;
  SL_ASSIGN_OR_RETURN(const std::vector<BenchScene> scenes, BenchScenesNamed(names));
  std::vector<std::string> plots;
  for (const BenchScene& scene : scenes) {
    SL_ASSIGN_OR_RETURN(const std::vector<std::string> pair, OneScene(scene, stated, table));
    SL_ASSIGN_OR_RETURN(const std::string path,
                        OutputPath(options, absl::StrCat("motion_", scene.name, ".svg")));
    SL_RETURN_IF_ERROR(WriteFileAtomically(path, pair.front()));
    plots.insert(plots.end(), pair.begin(), pair.end());
  }
  page.Figures(plots,
               "Left: a frame's time. Right: its error, without which the time says nothing; where the "
               "reference cannot tell it from none, the largest that it allows.");
  SL_ASSIGN_OR_RETURN(const std::vector<std::string> still, StillRow(options, table));
  page.Heading("Where nothing moves");
  page.Table({"scene", "still, s", "shutter open, s", "ratio", "equal bits"}, {still},
             "CPU time of all tiles of the frame, the least of fifteen runs each, turn by turn.");
  page.Heading("How this was measured");
  page.Paragraph(Provenance(stated));
  SL_ASSIGN_OR_RETURN(const std::string csv, OutputPath(options, "motion.csv"));
  SL_RETURN_IF_ERROR(table.Write(csv));
  SL_ASSIGN_OR_RETURN(const std::string html, OutputPath(options, "motion.html"));
  return page.Write(html);
}

}  // namespace shutterline::bench
