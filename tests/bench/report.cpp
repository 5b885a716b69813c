#include "tests/bench/report.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "common/base/build_id.h"
#include "tests/bench/machine.h"

namespace shutterline::bench {

absl::StatusOr<std::vector<Contender>> ChosenContenders(const ReportOptions& options) {
  std::vector<Contender> all = AllContenders(options.quick);
  if (options.contenders.empty()) return all;
  std::vector<Contender> chosen;
  for (const std::string& name : options.contenders) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Contender& c) { return c.name == name; });
    if (found == all.end()) {
      std::string known;
      for (const Contender& c : all) absl::StrAppend(&known, known.empty() ? "" : ", ", c.name);
      return absl::NotFoundError(absl::StrCat("no contender is named '", name, "'; there are ", known));
    }
    chosen.push_back(*found);
  }
  return chosen;
}

absl::StatusOr<std::string> OutputPath(const ReportOptions& options, const std::string& name) {
  std::error_code error;
  std::filesystem::create_directories(options.output, error);
  if (error) return absl::InternalError(absl::StrCat("make folder ", options.output, ": ", error.message()));
  return absl::StrCat(options.output, "/", name);
}

std::string Provenance(const ReportOptions& options) {
  const int squares = options.Side();
  return absl::StrCat("Build ", kBuildId, " on ", MachineName(), ", ", options.threads,
                      options.threads == 1 ? " thread" : " threads", ", load averages at the end ",
                      MachineLoad(), ". Frames of 1024 × 768. Time and error are measured over the same ",
                      squares == 1 ? std::string("tiles: all of them")
                                   : absl::StrCat("random tiles of 32 × 32 pixels, one of every square of ",
                                                  squares, " × ", squares),
                      "; a frame's time is set-up (pose, hierarchies) + tiles' time × tiles of the frame / "
                      "tiles measured, by ",
                      options.cpu_clock ? "CPU time of the process over the number of threads" : "wall clock",
                      ". Times of tiles are medians of ", options.MostRuns(),
                      " runs, of 3 where a run takes more than 1 s, of 1 "
                      "where it takes more than 3 s. "
                      "References have ",
                      options.Spp(), " points a pixel in two independent halves.");
}

}  // namespace shutterline::bench
