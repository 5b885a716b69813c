#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

#include "tests/bench/html_page.h"
#include "tests/bench/report.h"

/// What speed_vs_error.cpp is made of.
namespace shutterline::bench {

/// Every run with every setting, a row each.
absl::Status WriteSpeedCsv(const std::vector<SceneResult>& results, const ReportOptions& options);

/// The errors at which times are compared.
inline constexpr double kEpsilons[] = {0.01, 0.005, 0.0025};

/// One rival on one scene.
struct RivalOnScene {
  std::string scene;
  bool moves = true;
  Reading speed_up[3] = {};  ///< At kEpsilons: the rival's time over ours.
  double best_error = 0;     ///< The smallest that the rival reached...
  Reading at_best = {};      ///< ...and the speed-up there.
  double our_seconds = 0;    ///< Our default's time...
  Reading error_ratio = {};  ///< ...and the rival's error within it over ours.
};

/// Over scenes: the geometric mean of those whose figure is known or known from below, which then counts as
/// that bound; and the least.
struct Mean {
  int scenes = 0, bounds = 0;  ///< How many took part; how many of them with a bound from below.
  int without = 0;             ///< Scenes without a figure: bounded from above, or not at all.
  double value = 0, worst = 0;
  std::string worst_scene;

  std::string ToString() const;
};

std::vector<RivalOnScene> CompareWith(const std::string& rival, const std::vector<SceneResult>& results,
                                      const ReportOptions& options);
/// `which`: the index in kEpsilons, 3 for at_best, 4 for error_ratio. Of moving scenes only, if asked.
Mean MeanOf(const std::vector<RivalOnScene>& comparisons, int which, bool moving_only);

/// "line/slice": against which the others are held.
extern const char* const kOurs;

/// Tables of the page.
void AddDefaultsTable(HtmlPage& page, const std::vector<SceneResult>& results, const ReportOptions& options);
void AddSplitTable(HtmlPage& page, const std::vector<SceneResult>& results);
void AddCullingTable(HtmlPage& page, const std::vector<SceneResult>& results);

/// The tables that docs/performance.md holds, as Markdown.
absl::Status WriteSpeedMarkdown(const std::vector<SceneResult>& results,
                                const std::vector<Contender>& contenders, const ReportOptions& options);

absl::Status WriteSpeedPage(const std::vector<SceneResult>& results, const std::vector<Contender>& contenders,
                            const ReportOptions& options);

}  // namespace shutterline::bench
