#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "tests/bench/speed_vs_error.h"

namespace shutterline::bench {

const char* const kOurs = "line/slice";

std::vector<RivalOnScene> CompareWith(const std::string& rival, const std::vector<SceneResult>& results,
                                      const ReportOptions& options) {
  std::vector<RivalOnScene> comparisons;
  for (const SceneResult& result : results) {
    const TimeErrorCurve ours = result.Curve(kOurs, options), theirs = result.Curve(rival, options);
    RivalOnScene c{.scene = result.scene.name, .moves = result.scene.moves};
    for (size_t i = 0; i < std::size(kEpsilons); ++i) {
      c.speed_up[i] = Ratio(theirs.SecondsFor(kEpsilons[i]), ours.SecondsFor(kEpsilons[i]));
    }
    if (!theirs.envelope().empty()) {
      c.best_error = theirs.envelope().back().error;
      c.at_best = Ratio(theirs.SecondsFor(c.best_error), ours.SecondsFor(c.best_error));
    }
    if (const RunRow* row = result.DefaultOf(kOurs)) {
      c.our_seconds = row->Seconds(options);
      c.error_ratio = Ratio(theirs.ErrorWithin(c.our_seconds), {Reading::Kind::kExact, row->ErrorBound()});
    }
    comparisons.push_back(std::move(c));
  }
  return comparisons;
}

Mean MeanOf(const std::vector<RivalOnScene>& comparisons, int which, bool moving_only) {
  Mean mean;
  std::vector<double> values;
  for (const RivalOnScene& c : comparisons) {
    if (moving_only && !c.moves) continue;
    const Reading& reading = which < 3 ? c.speed_up[which] : which == 3 ? c.at_best : c.error_ratio;
    if (reading.kind != Reading::Kind::kExact && reading.kind != Reading::Kind::kAtLeast) {
      ++mean.without;
      continue;
    }
    mean.bounds += reading.kind == Reading::Kind::kAtLeast;
    if (values.empty() || reading.value < mean.worst) {
      mean.worst = reading.value;
      mean.worst_scene = c.scene;
    }
    values.push_back(reading.value);
  }
  mean.scenes = int(values.size());
  mean.value = GeometricMean(values).value_or(0);
  return mean;
}

std::string Mean::ToString() const {
  if (scenes == 0) return "–";
  std::string text = absl::StrCat(bounds > 0 ? "> " : "", absl::StrFormat("%.3g", value), " over ", scenes,
                                  scenes == 1 ? " scene" : " scenes");
  if (bounds > 0) absl::StrAppend(&text, " (", bounds, " by a bound)");
  if (without > 0) absl::StrAppend(&text, " and ", without, " without a figure");
  return absl::StrCat(text, "; worst ", absl::StrFormat("%.3g", worst), ", ", worst_scene);
}

}  // namespace shutterline::bench
