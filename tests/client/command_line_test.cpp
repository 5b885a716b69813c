#include "client/command_line.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <sstream>
#include <string>
#include <vector>

#include "client/commands.h"
#include "client/options.h"

namespace shutterline::client::command_line_test {
namespace {

using Words = std::vector<std::string>;

/// A command with the shared options that keeps what it was told instead of doing anything.
class Probe : public Command {
 public:
  explicit Probe(JobOptions& told) : told_(told) {}
  void Declare(CLI::App& app) override { AddJobOptions(app, options_); }
  absl::Status Check() override { return CheckJobOptions(options_); }
  absl::StatusOr<ExitCode> Run(Console&) override {
    told_ = options_;
    return ExitCode::kSuccess;
  }

 private:
  JobOptions& told_;
  JobOptions options_;
};

struct Outcome {
  int code = 0;
  std::string out, err;
  JobOptions told;
};

Outcome Tell(Words words) {
  Outcome outcome;
  std::ostringstream out, err;
  Console console{out, err};
  words.insert(words.begin(), "probe");
  outcome.code = RunCommandLine(
      words, {{"probe", "Probes", "Probe", [&] { return std::make_unique<Probe>(outcome.told); }}}, console);
  outcome.out = out.str();
  outcome.err = err.str();
  return outcome;
}

Outcome RunProgram(const Words& words) {
  Outcome outcome;
  std::ostringstream out, err;
  Console console{out, err};
  outcome.code = RunCommandLine(words, CommandTable(), console);
  outcome.out = out.str();
  outcome.err = err.str();
  return outcome;
}

/// Splits a command line of the help, which has no quotes.
Words Split(const std::string& line) {
  std::istringstream in(line);
  Words words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

TEST(Options, DefaultsAreThoseOfTheSettings) {
  const Outcome outcome = Tell({"fox.glb"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.told.settings, RenderSettings());
  EXPECT_EQ(outcome.told.output_settings, OutputSettings());
  EXPECT_EQ(outcome.told.frames, (FrameRange{1, 1, 1}));
  EXPECT_EQ(outcome.told.scene, "fox.glb");
  EXPECT_FALSE(outcome.told.output.has_value());
  EXPECT_FALSE(outcome.told.png);
}

TEST(Options, EachReachesItsSetting) {
  const Outcome outcome = Tell(
      Split("--frames -2-9x3 --fps 23.976 --size 640x480 --camera Cam#1 --animation all --shutter-open -0.25 "
            "--shutter-close 0.25 --integrator reference --pattern 4h4v --resolver paper --time-cells 7 "
            "--filter gaussian --filter-radius 2.25 --time-samples 17 --spp 256 --motion-degree 2 "
            "--motion-pieces 16 "
            "--seed 18446744073709551615 --float --compression piz --png -o out/f.##.exr fox.glb"));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  RenderSettings settings;
  settings.fps = 23.976;
  settings.width = 640;
  settings.height = 480;
  settings.camera = "Cam#1";
  settings.animation = "all";
  settings.shutter_open = -0.25;
  settings.shutter_close = 0.25;
  settings.integrator = IntegratorKind::kReference;
  settings.pattern = PatternKind::k4h4v;
  settings.resolver = ResolverKind::kPaper;
  settings.filter = FilterKind::kGaussian;
  settings.filter_radius = 2.25;
  settings.time_cells = 7;
  settings.time_samples = 17;
  settings.target_error.reset();
  settings.spp = 256;
  settings.motion_degree = 2;
  settings.motion_pieces = 16;
  settings.seed = ~uint64_t{0};
  EXPECT_EQ(outcome.told.settings, settings);
  EXPECT_EQ(outcome.told.frames, (FrameRange{-2, 9, 3}));
  EXPECT_EQ(outcome.told.output_settings, (OutputSettings{PixelType::kFloat, ExrCompression::kPiz}));
  EXPECT_EQ(outcome.told.output->FrameFile(4, 4), "out/f.04.exr");
  EXPECT_TRUE(outcome.told.png);
  EXPECT_EQ(Tell(Split("a.glb --time-step 0.125")).told.settings.time_step, 0.125);
  EXPECT_EQ(Tell(Split("a.glb --time-step 0.125")).told.settings.target_error, std::nullopt);
  EXPECT_EQ(Tell(Split("a.glb --target-error 0.004")).told.settings.target_error, 0.004);
  EXPECT_EQ(Tell(Split("a.glb --target-error 1e-5 --time-step 1")).told.settings.target_error, 1e-5);
  EXPECT_EQ(Tell(Split("a.glb --frame=-7 --half")).told.frames, (FrameRange{-7, -7, 1}));
}

TEST(Options, EveryPatternHasItsWordAndLinesNameThePatternOfSoMany) {
  for (const PatternKind pattern :
       {PatternKind::kAuto, PatternKind::k1h1v, PatternKind::k2h2v, PatternKind::k4h4v, PatternKind::k8h8v,
        PatternKind::k16h16v, PatternKind::kRgls}) {
    const Outcome outcome = Tell({"a.glb", "--pattern", std::string(ToString(pattern))});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.told.settings.pattern, pattern);
  }
  for (const auto& [lines, pattern] : {std::pair("2", PatternKind::k1h1v),
                                       {"4", PatternKind::kRgls},
                                       {"8", PatternKind::k4h4v},
                                       {"16", PatternKind::k8h8v},
                                       {"32", PatternKind::k16h16v}}) {
    const Outcome outcome = Tell({"a.glb", "--lines", lines});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.told.settings.pattern, pattern) << lines;
  }
}

TEST(Options, AnErrorToAimAtIsRefusedWhereItMeansNothing) {
  EXPECT_NE(Tell(Split("a.glb --target-error 0.01 --integrator stochastic"))
                .err.find("--target-error 0.01: means nothing to --integrator stochastic"),
            std::string::npos);
  EXPECT_NE(Tell(Split("a.glb --target-error 0.01 --resolver paper"))
                .err.find("--target-error 0.01: means nothing to --resolver paper"),
            std::string::npos);
}

TEST(Options, AFilterIsRefusedByMethodsThatKnowNone) {
  EXPECT_NE(Tell(Split("a.glb --filter triangle --integrator stochastic"))
                .err.find("filter triangle of radius 1: integrator stochastic knows none but box"),
            std::string::npos);
  EXPECT_NE(Tell(Split("a.glb --filter-radius 0.75 --resolver paper"))
                .err.find("filter box of radius 0.75: resolver paper knows none but box"),
            std::string::npos);
}

TEST(Options, HostileValuesAreUsageErrorsThatNameOptionValueAndRule) {
  const std::vector<std::pair<std::string, Words>> hostile = {
      {"--size", {"1e9x1", "0x0", "-5x5", "1024", "x", "32769x2", "1x", "99999999999999999999x1"}},
      {"--frame", {"1.5", "x", "nan", "1-2", "99999999"}},
      {"--frames", {"5-1", "1-5x0", "1-", "a-b", "1-2-3", "0-1000000", "1..5"}},
      {"--fps", {"0", "-24", "nan", "inf", "1e999", "24fps"}},
      {"--shutter-open", {"nan", "-inf", "1e7", "half"}},
      {"--shutter-close", {"nan", "inf", "0,5"}},
      {"--integrator", {"Line", "lines", "path"}},
      {"--pattern", {"RGLS", "3h3v", "32h32v"}},
      {"--lines", {"0", "3", "64", "-2", "4.0", "rgls"}},
      {"--resolver", {"paper?", "slice "}},
      {"--filter", {"Gaussian", "sinc", "blackman"}},
      {"--filter-radius", {"0", "0.49", "-1", "4.1", "nan", "wide"}},
      {"--time-cells", {"0", "-1", "65", "2.5"}},
      {"--time-step", {"0", "-1", "nan", "1e-9"}},
      {"--time-samples", {"0", "-1", "65537", "2.5"}},
      {"--target-error", {"0", "-0.1", "9e-6", "0.6", "nan", "inf", "1%"}},
      {"--motion-degree", {"0", "4", "-1", "quadratic"}},
      {"--motion-pieces", {"0", "3", "128", "-1"}},
      {"--spp", {"0", "-1", "1048577", "1e3"}},
      {"--seed", {"-1", "18446744073709551616", "x"}},
      {"--compression", {"gzip", "ZIP"}},
      {"--output", {"out.png", "dir/", "a#b#.exr", "--float"}},
  };
  for (const auto& [option, values] : hostile) {
    for (const std::string& value : values) {
      const Outcome outcome = Tell({"fox.glb", option, value});
      EXPECT_EQ(outcome.code, 2) << option << " " << value;
      EXPECT_EQ(outcome.err.rfind("shutterline: ", 0), 0u) << outcome.err;
      EXPECT_NE(outcome.err.find(option), std::string::npos) << outcome.err;
      EXPECT_NE(outcome.err.find("'" + value + "'"), std::string::npos) << outcome.err;
      EXPECT_NE(outcome.err.find("must"), std::string::npos) << outcome.err;
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
    EXPECT_EQ(Tell({"fox.glb", option, ""}).code, 2) << option << " with an empty text";
    EXPECT_EQ(Tell({"fox.glb", option}).code, 2) << option << " without a value";
  }
}

TEST(Options, ContradictionsAreUsageErrors) {
  for (const char* line :
       {"", "a.glb b.glb", "a.glb --frame 1 --frames 1-2", "a.glb --half --float", "a.glb --nonsense",
        "a.glb --time-step 1 --time-samples 2", "a.glb --target-error 0.01 --time-samples 2",
        "a.glb --target-error 0.01 --integrator reference",
        "a.glb --target-error 0.01 --integrator stochastic", "a.glb --target-error 0.01 --resolver paper",
        "a.glb --lines 4 --pattern rgls", "a.glb --shutter-open 0.6", "a.glb --size 1x1 --size 2x2",
        "a.glb --shutter-open 0 --shutter-close -1", "a.glb --si 1x1"}) {
    const Outcome outcome = Tell(Split(line));
    EXPECT_EQ(outcome.code, 2) << line;
    EXPECT_EQ(outcome.err.rfind("shutterline: ", 0), 0u) << line << ": " << outcome.err;
  }
  EXPECT_EQ(Tell({""}).code, 2) << "an empty scene";
  EXPECT_NE(Tell(Split("a.glb --shutter-open 0.6")).err.find("--shutter-close 0.5 (the default)"),
            std::string::npos);
}

TEST(Options, ControlCharactersDoNotReachTheTerminal) {
  const Outcome outcome = Tell({"a.glb", "--size", "\x1b[2J\n1x1"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.err.find('\x1b'), std::string::npos);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
}

TEST(Program, HelpMentionsEveryOptionAndTeachesByExamplesThatParse) {
  for (const CommandEntry& entry : CommandTable()) {
    const Outcome help = RunProgram({entry.name, "--help"});
    ASSERT_EQ(help.code, 0) << entry.name;
    EXPECT_EQ(help.err, "");
    EXPECT_NE(help.out.find(entry.summary), std::string::npos) << entry.name;

    std::vector<std::unique_ptr<Command>> commands;
    const auto parser = MakeParser(CommandTable(), commands);
    const CLI::App* app = parser->get_subcommand(entry.name);
    for (const CLI::Option* option : app->get_options()) {
      const std::string name =
          option->get_positional() ? option->get_name(true) : option->get_name(false, true);
      EXPECT_NE(help.out.find(name), std::string::npos) << entry.name << ": " << name;
      EXPECT_GT(option->get_description().size(), 5u) << entry.name << ": " << name << " is not explained";
    }

    size_t examples = 0;
    std::istringstream lines(help.out);
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind("  shutterline ", 0) != 0) continue;
      ++examples;
      Words words = Split(line);
      words.erase(words.begin());
      EXPECT_EQ(words.front(), entry.name) << line;
      std::vector<std::unique_ptr<Command>> fresh;
      const auto one = MakeParser(CommandTable(), fresh);
      setenv("SHUTTERLINE_SERVER", "farm:7400", 1);
      EXPECT_NO_THROW(one->parse(Words(words.rbegin(), words.rend()))) << line;
      for (size_t i = 0; i < CommandTable().size(); ++i) {
        if (words.front() != CommandTable()[i].name) continue;
        const absl::Status usage = fresh[i]->Check();
        EXPECT_TRUE(usage.ok()) << line << ": " << usage;
      }
      unsetenv("SHUTTERLINE_SERVER");
    }
    EXPECT_GE(examples, 1u) << entry.name << " shows no example";
  }
}

TEST(Program, HelpNamesDefaultsAsTheyAre) {
  const RenderSettings s;
  const std::string help = RunProgram({"submit", "--help"}).out;
  const std::string size = std::to_string(s.width) + "x" + std::to_string(s.height);
  for (const std::string& text : std::vector<std::string>{
           "FRAMES/S [" + std::to_string(int(s.fps)) + "]", "WxH [" + size + "]",
           "[" + std::string(ToString(s.pattern)) + "]", "[" + std::string(ToString(s.resolver)) + "]",
           "[" + std::string(ToString(s.integrator)) + "]", "N [" + std::to_string(s.spp) + "]",
           "FRAMES [0.5]", "FRAMES [0]", "E [" + absl::StrCat(*s.target_error) + "]", "[zip]"}) {
    EXPECT_NE(help.find(text), std::string::npos) << text << "\n" << help;
  }
  EXPECT_EQ(s.shutter_close, 0.5);
  EXPECT_EQ(s.shutter_open, 0.0);
  EXPECT_EQ(OutputSettings().compression, ExrCompression::kZip);
}

TEST(Program, ListsItsCommandsAndRefusesOthers) {
  const Outcome help = RunProgram({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const CommandEntry& entry : CommandTable()) {
    EXPECT_NE(help.out.find(std::string("  ") + entry.name), std::string::npos) << entry.name;
  }
  EXPECT_EQ(RunProgram({"--version"}).out.rfind("shutterline ", 0), 0u);
  EXPECT_EQ(RunProgram({}).code, 2);
  EXPECT_EQ(RunProgram({"rendr"}).code, 2);
  EXPECT_EQ(RunProgram({"status"}).code, 2);
}

TEST(Program, FarmCommandsAskForAServer) {
  unsetenv("SHUTTERLINE_SERVER");
  for (const char* line :
       {"list", "workers", "status 0f8fad5b-d9cb-469f-a165-70867728950e", "submit a.glb"}) {
    const Outcome outcome = RunProgram(Split(line));
    EXPECT_EQ(outcome.code, 2) << line;
    EXPECT_NE(outcome.err.find("--server HOST:PORT"), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(RunProgram(Split("list --server nonsense")).code, 2);
  EXPECT_EQ(RunProgram(Split("status not-a-job --server a:1")).code, 2);
  EXPECT_EQ(RunProgram(Split("submit a.glb --server a:1 -o a.exr")).code, 2) << "-o without --wait";
  EXPECT_EQ(RunProgram(Split("submit a.glb --server a:1 --png")).code, 2) << "--png without --wait";
  EXPECT_EQ(RunProgram(Split("submit a.glb --server a:1 --stats")).code, 2) << "--stats without --wait";
}

}  // namespace
}  // namespace shutterline::client::command_line_test
