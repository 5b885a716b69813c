#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include "common/base/atomic_file.h"
#include "common/base/status_macros.h"
#include "tests/bench/speed_vs_error.h"

namespace shutterline::bench {
namespace {

using Row = std::vector<std::string>;

std::string Table(const Row& columns, const std::vector<Row>& rows) {
  std::string text = absl::StrCat("| ", absl::StrJoin(columns, " | "), " |\n|", "---|");
  for (size_t i = 1; i < columns.size(); ++i) text += "---|";
  text += "\n";
  for (const Row& row : rows) absl::StrAppend(&text, "| ", absl::StrJoin(row, " | "), " |\n");
  return text + "\n";
}

std::string Rmse(const UnbiasedError& e) {
  if (e.pixels == 0) return "";
  return e.BelowFloor() ? "below floor" : absl::StrFormat("%.4f", e.Rmse());
}

}  // namespace

absl::Status WriteSpeedMarkdown(const std::vector<SceneResult>& results,
                                const std::vector<Contender>& contenders, const ReportOptions& options) {
  std::string text = absl::StrCat(Provenance(options), "\n\n");
  Row columns = {"scene",  "triangles", "method", "pose + build, s", "frame, s",
                 "CPU, s", "RMSE",      "moving", "static edges",    "disocclusions"};
  std::vector<Row> rows;
  for (const SceneResult& result : results) {
    for (const RunRow& run : result.runs) {
      if (!run.is_default) continue;
      const Measurement& m = run.measurement;
      rows.push_back({result.scene.name, absl::StrCat(result.triangles), run.contender,
                      absl::StrFormat("%.3f", m.pose_wall + m.build_wall),
                      absl::StrFormat("%.3g", m.FrameWall()), absl::StrFormat("%.3g", m.FrameCpu()),
                      Rmse(run.errors.whole), Rmse(run.errors.moving), Rmse(run.errors.static_edges),
                      Rmse(run.errors.disocclusions)});
    }
  }
  absl::StrAppend(&text, "Default settings:\n\n", Table(columns, rows));

  columns = {"rival of line/slice", "S(0.01)", "S(0.005)", "S(0.0025)", "S at its least error", "Q"};
  rows.clear();
  for (const Contender& rival : contenders) {
    if (rival.name == kOurs) continue;
    const auto comparisons = CompareWith(rival.name, results, options);
    for (const bool moving : {true, false}) {
      Row row = {absl::StrCat(rival.name, moving ? ", moving scenes" : ", all scenes")};
      for (int which = 0; which < 5; ++which) row.push_back(MeanOf(comparisons, which, moving).ToString());
      rows.push_back(std::move(row));
    }
  }
  if (!rows.empty()) absl::StrAppend(&text, "Geometric means:\n\n", Table(columns, rows));

  rows.clear();
  for (const SceneResult& result : results) {
    if (!result.split || !result.truth) continue;
    rows.push_back(
        {result.scene.name, Rmse(result.split->total), Rmse(result.split->space), Rmse(result.split->shade),
         Rmse(result.split->rest),
         absl::StrFormat("%.4f %%", 100.0 * double(result.truth->same) / double(result.truth->samples))});
  }
  if (!rows.empty()) {
    absl::StrAppend(&text, "Where the default's error comes from:\n\n",
                    Table({"scene", "total", "E space", "E shade", "E rest", "same triangle"}, rows));
  }
  SL_ASSIGN_OR_RETURN(const std::string path, OutputPath(options, "speed_vs_error.md"));
  return WriteFileAtomically(path, text);
}

}  // namespace shutterline::bench
