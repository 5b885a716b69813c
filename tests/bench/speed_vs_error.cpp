#include "tests/bench/speed_vs_error.h"

#include <cstdio>

#include "common/base/status_macros.h"
#include "tests/bench/commands.h"
#include "tests/bench/stopwatch.h"

namespace shutterline::bench {

absl::Status SpeedVsError(const ReportOptions& options) {
  const Stopwatch watch;
  SL_ASSIGN_OR_RETURN(const std::vector<Contender> contenders, ChosenContenders(options));
  std::vector<BenchScene> scenes = options.quick ? QuickBenchScenes() : AllBenchScenes();
  if (!options.scenes.empty()) {
    SL_ASSIGN_OR_RETURN(scenes, BenchScenesNamed(options.scenes));
  }
  std::vector<SceneResult> results;
  for (const BenchScene& scene : scenes) {
    SL_ASSIGN_OR_RETURN(SceneResult result, RunScene(scene, contenders, options));
    results.push_back(std::move(result));
    // After every scene, so that a run that is cut short leaves what it has.
    SL_RETURN_IF_ERROR(WriteSpeedCsv(results, options));
    SL_RETURN_IF_ERROR(WriteSpeedMarkdown(results, contenders, options));
    SL_RETURN_IF_ERROR(WriteSpeedPage(results, contenders, options));
  }
  std::printf("\n");
  for (const Contender& rival : contenders) {
    if (rival.name == kOurs) continue;
    const auto comparisons = CompareWith(rival.name, results, options);
    std::printf("%s over %s, geometric means:\n", kOurs, rival.name.c_str());
    for (int i = 0; i < 3; ++i) {
      std::printf("  S(%g)  moving scenes %s\n           all scenes    %s\n", kEpsilons[i],
                  MeanOf(comparisons, i, true).ToString().c_str(),
                  MeanOf(comparisons, i, false).ToString().c_str());
    }
    std::printf("  S at its best error  %s\n", MeanOf(comparisons, 3, false).ToString().c_str());
    std::printf("  Q in our default's time  %s\n", MeanOf(comparisons, 4, false).ToString().c_str());
  }
  std::printf("\n%s\nDone in %.0f s; wrote %s/speed_vs_error.{csv,html,md} and %s/time_to_error_*.svg\n",
              Provenance(options).c_str(), watch.Wall(), options.output.c_str(), options.output.c_str());
  return absl::OkStatus();
}

}  // namespace shutterline::bench
