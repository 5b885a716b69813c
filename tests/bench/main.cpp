#include <CLI/CLI.hpp>
#include <cstdio>
#include <thread>

#include "tests/bench/commands.h"

namespace {

using shutterline::bench::Against;
using shutterline::bench::MeasureOne;
using shutterline::bench::ReportOptions;

/// Options that not everything has a use for; kReport: those of all parts.
enum Use : unsigned { kReport = 1, kContenders = 2, kSide = 4, kClock = 8, kCache = 16, kSpp = 32 };

struct Part {
  const char* name;
  const char* summary;
  absl::Status (*run)(const ReportOptions&);
  unsigned uses;
};

constexpr Part kParts[] = {
    {"speed-vs-error", "Ladders of every method on every scene: time against error",
     shutterline::bench::SpeedVsError, kReport | kContenders | kSide | kClock | kCache | kSpp},
    {"motion", "Time and error against the length of motion", shutterline::bench::Motion,
     kReport | kContenders | kSide | kClock | kCache | kSpp},
    {"stages", "Where the line integrator's time goes", shutterline::bench::Stages,
     kReport | kContenders | kSide},
    {"depth-error", "Errors of the depth of single samples", shutterline::bench::DepthError, kReport | kSide},
    {"patterns", "Patterns of lines on a still frame", shutterline::bench::Patterns,
     kReport | kClock | kCache | kSpp},
    {"occlusion", "Ambient occlusion by lines and by rays", shutterline::bench::Occlusion, kReport | kSpp},
};

void AddOptions(CLI::App& sub, unsigned uses, ReportOptions& options, std::string& clock) {
  sub.add_option("--threads", options.threads, "Threads of every method")->check(CLI::Range(1, 1024));
  if (uses & kReport) {
    sub.add_flag("--quick", options.quick,
                 "A first look: fewer scenes, tiles and settings; within 3 minutes on 2 cores");
    sub.add_option("-o,--output", options.output, "Folder to write to")->capture_default_str();
    sub.add_option("--scenes", options.scenes, "Only these scenes");
  }
  if (uses & kCache) {
    sub.add_option("--cache", options.cache, "Folder in which references are kept")->capture_default_str();
  }
  if (uses & kClock) {
    sub.add_option("--clock", clock, "What curves show: wall, or cpu (over threads) on a busy machine")
        ->check(CLI::IsMember({"wall", "cpu"}));
  }
  if (uses & kContenders) sub.add_option("--contenders", options.contenders, "Only these methods");
  if (uses & kSide) {
    sub.add_option("--side", options.side, "Measure one tile of every square of this many a side; 1: all")
        ->check(CLI::Range(1, 32));
  }
  if (uses & kSpp) {
    sub.add_option("--spp", options.spp, "Points, or rays, a pixel of references, a multiple of 64")
        ->check(CLI::Range(64, 1 << 16));
  }
}

}  // namespace

/// Exit codes: 0 success, 1 failed (a NaN in a picture is a failure), 2 usage.
int main(int argc, char** argv) {
  CLI::App app("Measures speed against error and writes the report: CSV, SVG and a page of HTML.",
               "shutterline-bench");
  app.require_subcommand(1);
  ReportOptions options;
  options.threads = int(std::max(1u, std::thread::hardware_concurrency()));
  std::string clock = "wall";
  const Part* chosen = nullptr;
  std::string against, scene, contender;
  int rung = -1;
  for (const Part& part : kParts) {
    CLI::App* sub = app.add_subcommand(part.name, part.summary);
    AddOptions(*sub, part.uses, options, clock);
    if (&part == kParts) {
      sub->add_option(
          "--against", against,
          "Instead, run the default settings by this build and by the one in this folder, turn by "
          "turn, and print the ratios of their times");
    }
    sub->callback([&chosen, &part] { chosen = &part; });
  }
  CLI::App* one = app.add_subcommand("measure-one", "One measurement, for --against: scene, method, rung");
  one->add_option("scene", scene)->required();
  one->add_option("contender", contender)->required();
  one->add_option("rung", rung);
  AddOptions(*one, kSide, options, clock);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  options.cpu_clock = clock == "cpu";
  options.spp -= options.spp % 64;
  const absl::Status status = chosen == nullptr  ? MeasureOne(options, scene, contender, rung)
                              : !against.empty() ? Against(options, against)
                                                 : chosen->run(options);
  if (!status.ok()) {
    std::fprintf(stderr, "shutterline-bench: %s\n", std::string(status.message()).c_str());
    return 1;
  }
  return 0;
}
