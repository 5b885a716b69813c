#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

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

absl::Status Stages(const ReportOptions& options) {
  std::vector<BenchScene> scenes = options.quick ? QuickBenchScenes() : AllBenchScenes();
  if (!options.scenes.empty()) {
    SL_ASSIGN_OR_RETURN(scenes, BenchScenesNamed(options.scenes));
  }
  SL_ASSIGN_OR_RETURN(const std::vector<Contender> contenders, ChosenContenders(options));
  CsvTable table({"commit",         "machine",    "threads", "scene",    "triangles", "method",    "tiles",
                  "tiles_in_frame", "pose_s",     "build_s", "cull_s",   "setup_s",   "resolve_s", "shade_s",
                  "tiles_cpu_s",    "candidates", "lines",   "instants", "segments",  "spans",     "pairs"});
  HtmlPage page("Where the time goes");
  page.Paragraph(
      "Stages of the line integrator at its default setting, in seconds of CPU for a whole frame. After "
      "figure "
      "14 of Gribel et al. 2011.");
  for (const Contender& contender : contenders) {
    if (contender.default_rung < 0) continue;
    BarChart chart{.title = absl::StrCat(contender.name, ": parts of a frame's CPU time, and all of it"),
                   .unit = "%",
                   .part_labels = {"pose", "hierarchy", "cull", "set up", "resolve", "shade"},
                   .bars = {}};
    for (const BenchScene& scene : scenes) {
      SL_ASSIGN_OR_RETURN(const LoadedScene loaded, Load(scene));
      RenderSettings settings = scene.settings;
      contender.ladder[size_t(contender.default_rung)].apply(settings);
      const TileSubset subset = StratifiedTiles(settings.width, settings.height, options.Side(), 5);
      SL_ASSIGN_OR_RETURN(const Measurement m, Measure(loaded.scene, scene.frame, settings, subset,
                                                       {.threads = options.threads, .most_runs = 1}));
      const engine::RenderStats& s = m.stats;
      // Stages are timed by the clock of the thread that they run on; on a busy machine these add up to more
      // than the CPU's time, which they are scaled to.
      const double sum = s.cull_seconds + s.setup_seconds + s.resolve_seconds + s.shade_seconds;
      const double scale = sum > 0 ? m.tiles_cpu / sum / m.share : 0;
      BarChart::Bar bar{.label = scene.name,
                        .parts = {m.pose_cpu, m.build_cpu, scale * s.cull_seconds, scale * s.setup_seconds,
                                  scale * s.resolve_seconds, scale * s.shade_seconds},
                        .note = ""};
      std::printf(
          "%-16s %-12s pose %.3f  build %.3f  cull %.3f  set up %.3f  resolve %.3f  shade %.3f s a frame\n",
          scene.name.c_str(), contender.name.c_str(), bar.parts[0], bar.parts[1], bar.parts[2], bar.parts[3],
          bar.parts[4], bar.parts[5]);
      std::fflush(stdout);
      table.AddRow({kBuildId,
                    MachineName(),
                    Cell(int64_t{options.threads}),
                    scene.name,
                    "",
                    contender.name,
                    Cell(int64_t(subset.tiles.size())),
                    Cell(int64_t{subset.tiles_in_frame}),
                    Cell(bar.parts[0]),
                    Cell(bar.parts[1]),
                    Cell(bar.parts[2]),
                    Cell(bar.parts[3]),
                    Cell(bar.parts[4]),
                    Cell(bar.parts[5]),
                    Cell(m.tiles_cpu),
                    Cell(s.candidate_triangles),
                    Cell(s.lines),
                    Cell(s.instants),
                    Cell(s.segments),
                    Cell(s.spans),
                    Cell(s.pairs)});
      double total = 0;
      for (const double part : bar.parts) total += part;
      for (double& part : bar.parts) part *= 100 / total;
      bar.note = absl::StrFormat("%.3g s", total);
      chart.bars.push_back(std::move(bar));
    }
    const std::string svg = RenderBars(chart);
    std::string name = contender.name;
    for (char& c : name) c = c == '/' ? '_' : c;
    SL_ASSIGN_OR_RETURN(const std::string path, OutputPath(options, absl::StrCat("stages_", name, ".svg")));
    SL_RETURN_IF_ERROR(WriteFileAtomically(path, svg));
    page.Figures({svg}, "");
  }
  page.Heading("How this was measured");
  page.Paragraph(Provenance(options));
  SL_ASSIGN_OR_RETURN(const std::string csv, OutputPath(options, "stages.csv"));
  SL_RETURN_IF_ERROR(table.Write(csv));
  SL_ASSIGN_OR_RETURN(const std::string html, OutputPath(options, "stages.html"));
  return page.Write(html);
}

}  // namespace shutterline::bench
