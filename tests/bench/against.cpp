#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "common/asset/digest.h"
#include "common/base/build_id.h"
#include "common/base/status_macros.h"
#include "tests/bench/commands.h"
#include "tests/bench/csv.h"
#include "tests/bench/machine.h"

namespace shutterline::bench {
namespace {

constexpr int kRounds = 5;

struct Reply {
  double wall = 0, cpu = 0;  ///< Of a frame, seconds.
  std::string picture;       ///< Digest.
};

/// For the shell.
std::string Quoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

absl::StatusOr<Reply> Ask(const std::string& program, const std::string& scene, const std::string& contender,
                          int rung, const ReportOptions& options) {
  const std::string command =
      absl::StrCat(Quoted(program), " measure-one ", Quoted(scene), " ", Quoted(contender), " ", rung,
                   " --threads ", options.threads, " --side ", options.Side());
  const auto close = [](FILE* pipe) { pclose(pipe); };
  std::unique_ptr<FILE, decltype(close)> pipe(popen(command.c_str(), "r"), close);
  if (pipe == nullptr) return absl::InternalError(absl::StrCat("run ", program));
  std::string output;
  std::array<char, 512> buffer;
  while (std::fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr) output += buffer.data();
  const std::vector<std::string> words = absl::StrSplit(output, absl::ByAnyChar(" \n"), absl::SkipEmpty());
  Reply reply;
  if (words.size() != 4 || words[0] != "measured" || !absl::SimpleAtod(words[1], &reply.wall) ||
      !absl::SimpleAtod(words[2], &reply.cpu)) {
    return absl::InternalError(absl::StrCat(program, " measured nothing for ", scene, ", ", contender));
  }
  reply.picture = words[3];
  return reply;
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace

absl::Status MeasureOne(const ReportOptions& options, const std::string& scene_name,
                        const std::string& contender_name, int rung) {
  ReportOptions chosen = options;
  chosen.contenders = {contender_name};
  SL_ASSIGN_OR_RETURN(const std::vector<Contender> contenders, ChosenContenders(chosen));
  SL_ASSIGN_OR_RETURN(const std::vector<BenchScene> scenes, BenchScenesNamed({scene_name}));
  const Contender& contender = contenders.front();
  const BenchScene& scene = scenes.front();
  // Rung −1 is the default setting, or 64 points a pixel where there is none.
  int index = rung >= 0 ? rung : contender.default_rung;
  for (int i = 0; index < 0 && i < int(contender.ladder.size()); ++i) {
    if (contender.ladder[size_t(i)].label == "64 spp") index = i;
  }
  if (index < 0 || index >= int(contender.ladder.size())) {
    return absl::InvalidArgumentError(absl::StrCat(contender.name, " has no rung ", rung));
  }
  SL_ASSIGN_OR_RETURN(const LoadedScene loaded, Load(scene));
  RenderSettings settings = scene.settings;
  contender.ladder[size_t(index)].apply(settings);
  const TileSubset subset = StratifiedTiles(settings.width, settings.height, options.Side(), 5);
  SL_ASSIGN_OR_RETURN(const Measurement m, Measure(loaded.scene, scene.frame, settings, subset,
                                                   {.threads = options.threads, .most_runs = 3}));
  const std::vector<float>& values = m.pictures.front().values();
  const Digest digest = Sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)});
  std::printf("measured %.6f %.6f %s\n", m.FrameWall(), m.FrameCpu(), digest.ToHex().substr(0, 16).c_str());
  return absl::OkStatus();
}

absl::Status Against(const ReportOptions& options, const std::string& build_folder) {
  const std::string ours = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string theirs = absl::StrCat(build_folder, "/bin/shutterline-bench");
  if (!std::filesystem::exists(theirs)) return absl::NotFoundError(absl::StrCat("there is no ", theirs));
  std::vector<BenchScene> scenes = options.quick ? QuickBenchScenes() : AllBenchScenes();
  if (!options.scenes.empty()) {
    SL_ASSIGN_OR_RETURN(scenes, BenchScenesNamed(options.scenes));
  }
  SL_ASSIGN_OR_RETURN(const std::vector<Contender> contenders, ChosenContenders(options));
  CsvTable table({"commit", "machine", "threads", "scene", "contender", "wall_s", "cpu_s", "other_wall_s",
                  "other_cpu_s", "cpu_ratio", "equal_pictures"});
  std::printf("%-16s %-12s %10s %10s %8s  pictures\n", "scene", "method", "this, s", "other, s", "ratio");
  std::vector<double> ratios;
  for (const BenchScene& scene : scenes) {
    for (const Contender& contender : contenders) {
      std::vector<double> cpu[2], wall[2];
      std::string pictures[2];
      bool measured = true;
      for (int round = 0; round < kRounds && measured; ++round) {
        for (const int which : {round % 2, 1 - round % 2}) {  // Neither is always first.
          const auto reply = Ask(which == 0 ? ours : theirs, scene.name, contender.name, -1, options);
          if (!reply.ok()) {
            std::printf("%-16s %-12s %s\n", scene.name.c_str(), contender.name.c_str(),
                        std::string(reply.status().message()).c_str());
            measured = false;
            break;
          }
          cpu[which].push_back(reply->cpu);
          wall[which].push_back(reply->wall);
          pictures[which] = reply->picture;
        }
        if (measured && wall[0].back() > 30) break;  // Once is enough to see it.
      }
      if (!measured) continue;
      const double ratio = Median(cpu[0]) / Median(cpu[1]);
      ratios.push_back(ratio);
      std::printf("%-16s %-12s %10.4f %10.4f %8.3f  %s\n", scene.name.c_str(), contender.name.c_str(),
                  Median(cpu[0]), Median(cpu[1]), ratio,
                  pictures[0] == pictures[1] ? "equal bits" : "different");
      std::fflush(stdout);
      table.AddRow({kBuildId, MachineName(), Cell(int64_t{options.threads}), scene.name, contender.name,
                    Cell(Median(wall[0])), Cell(Median(cpu[0])), Cell(Median(wall[1])), Cell(Median(cpu[1])),
                    Cell(ratio), pictures[0] == pictures[1] ? "1" : "0"});
    }
  }
  if (const auto mean = GeometricMean(ratios)) {
    std::printf("this build takes %.3f times the other's CPU time (geometric mean)\n", *mean);
  }
  SL_ASSIGN_OR_RETURN(const std::string csv, OutputPath(options, "against.csv"));
  return table.Write(csv);
}

}  // namespace shutterline::bench
