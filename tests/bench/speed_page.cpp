#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>

#include "common/base/atomic_file.h"
#include "common/base/status_macros.h"
#include "tests/bench/html_page.h"
#include "tests/bench/speed_vs_error.h"
#include "tests/bench/svg_plot.h"

namespace shutterline::bench {
namespace {

Plot TimeToError(const SceneResult& result, const std::vector<Contender>& contenders,
                 const ReportOptions& options) {
  Plot plot{.title = absl::StrCat(result.scene.name, ", ", result.triangles, " triangles"),
            .x = {"seconds a frame", true},
            .y = {"RMSE, linear", true}};
  for (const Contender& contender : contenders) {
    PlotSeries series{.label = contender.name,
                      .color = contender.color,
                      .points = {},
                      .line = {},
                      .hollow = !contender.ours};
    for (const RunRow& row : result.runs) {
      if (row.contender != contender.name) continue;
      series.points.push_back({row.Seconds(options), row.ErrorBound()});
      if (row.is_default) series.star = series.points.back();
    }
    const TimeErrorCurve curve = result.Curve(contender.name, options);
    for (const TimeError& point : curve.envelope()) {
      series.line.push_back({point.seconds, point.error});
    }
    plot.series.push_back(std::move(series));
  }
  plot.rules.push_back({0.005, "0.005"});
  return plot;
}

/// Geometric mean, over the scenes where a method reached an error at all, of its time for it.
std::string Headline(const std::vector<SceneResult>& results, const std::vector<Contender>& contenders,
                     const ReportOptions& options) {
  Plot plot{.title = "Seconds for a frame of a given error, geometric mean of the scenes",
            .x = {"seconds a frame", true},
            .y = {"RMSE, linear", true},
            .width = 720,
            .height = 430};
  for (const Contender& contender : contenders) {
    PlotSeries series{.label = contender.name, .color = contender.color};
    for (double error = 0.04; error > 0.0004; error /= 1.12) {
      std::vector<double> seconds;
      for (const SceneResult& result : results) {
        const Reading reading = result.Curve(contender.name, options).SecondsFor(error);
        if (reading.kind == Reading::Kind::kExact || reading.kind == Reading::Kind::kAtMost) {
          seconds.push_back(reading.value);
        }
      }
      // Where a scene is missing, the mean would be of others: the curve ends.
      if (seconds.size() == results.size()) series.line.push_back({*GeometricMean(seconds), error});
    }
    plot.series.push_back(std::move(series));
  }
  plot.rules.push_back({0.005, "0.005"});
  return RenderPlot(plot);
}

void AddSpeedUps(HtmlPage& page, const std::vector<SceneResult>& results, const std::string& rival,
                 const ReportOptions& options) {
  const auto comparisons = CompareWith(rival, results, options);
  std::vector<std::vector<std::string>> rows;
  for (const RivalOnScene& c : comparisons) {
    rows.push_back({c.scene, c.speed_up[0].ToString(), c.speed_up[1].ToString(), c.speed_up[2].ToString(),
                    absl::StrFormat("%.4f", c.best_error), c.at_best.ToString(),
                    absl::StrFormat("%.3g", c.our_seconds), c.error_ratio.ToString()});
  }
  const auto mean_row = [&](const std::string& label, bool moving) {
    std::vector<std::string> row = {label};
    for (const int which : {0, 1, 2}) row.push_back(MeanOf(comparisons, which, moving).ToString());
    row.insert(row.end(), {"", MeanOf(comparisons, 3, moving).ToString(), "",
                           MeanOf(comparisons, 4, moving).ToString()});
    for (std::string& cell : row) cell = cell.substr(0, cell.find(" over "));
    return row;
  };
  rows.push_back(mean_row("=moving scenes", true));
  rows.push_back(mean_row("=all scenes", false));
  const Mean worst = MeanOf(comparisons, 1, false);
  page.Heading(absl::StrCat(kOurs, " over ", rival));
  page.Table(
      {"scene", "S(0.01)", "S(0.005)", "S(0.0025)", "its least error", "S there", "our default, s", "Q"},
      rows,
      absl::StrCat(
          "S(ε): how many times longer ", rival,
          " takes for an RMSE of ε. Q: its error within the time of "
          "our default over our error. “>”: the rival never got there (nothing is extrapolated) or our "
          "cheapest setting is better already; “≤”: the other way round; “–”: neither can be told. Means are "
          "geometric, over scenes with a figure or a bound from below, which counts as that bound. Worst at "
          "0.005: ",
          worst.scenes == 0 ? "–"
                            : absl::StrCat(worst.worst_scene, ", ", absl::StrFormat("%.3g", worst.worst)),
          "."));
}

}  // namespace

absl::Status WriteSpeedPage(const std::vector<SceneResult>& results, const std::vector<Contender>& contenders,
                            const ReportOptions& options) {
  HtmlPage page(options.quick ? "Speed against error, a quick look" : "Speed against error");
  page.Paragraph(
      "Every method renders the same moving triangles under the same box filter and shutter. A curve is a "
      "method's Pareto "
      "envelope over its ladder of settings: below and to the left is better. Stars are default settings. "
      "Errors are root mean "
      "squares of linear values, unbiased by the reference's noise.");
  const std::string headline = Headline(results, contenders, options);
  page.Figures({headline}, "Each curve ends where one of the scenes has no run of so small an error.");
  SL_ASSIGN_OR_RETURN(const std::string headline_path, OutputPath(options, "time_to_error.svg"));
  SL_RETURN_IF_ERROR(WriteFileAtomically(headline_path, headline));
  std::vector<std::string> plots;
  for (const SceneResult& result : results) {
    plots.push_back(RenderPlot(TimeToError(result, contenders, options)));
    SL_ASSIGN_OR_RETURN(const std::string path,
                        OutputPath(options, absl::StrCat("time_to_error_", result.scene.name, ".svg")));
    SL_RETURN_IF_ERROR(WriteFileAtomically(path, plots.back()));
  }
  page.Heading("Time to error, scene by scene");
  page.Figures(plots,
               "A point for each setting; lines join the best. An error that the reference cannot tell from "
               "none stands "
               "at the largest that it allows.");
  for (const Contender& contender : contenders) {
    if (contender.name != kOurs) AddSpeedUps(page, results, contender.name, options);
  }
  AddDefaultsTable(page, results, options);
  AddSplitTable(page, results);
  AddCullingTable(page, results);
  page.Heading("How this was measured");
  page.Paragraph(Provenance(options));
  SL_ASSIGN_OR_RETURN(const std::string path, OutputPath(options, "speed_vs_error.html"));
  return page.Write(path);
}

}  // namespace shutterline::bench
