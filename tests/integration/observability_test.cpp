#include <absl/strings/str_split.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/integration/farm.h"

namespace shutterline {
namespace {

using nlohmann::json;

constexpr int kTiles = 9 * 7;

class ObservabilityTest : public testing::Test {
 protected:
  /// The lines of a log that hold `text`.
  static std::vector<std::string> Lines(const std::string& log, const std::string& text) {
    std::vector<std::string> lines;
    for (const absl::string_view line : absl::StrSplit(log, '\n')) {
      if (line.find(text) != absl::string_view::npos) lines.emplace_back(line);
    }
    return lines;
  }

  static void ExpectFields(const std::string& line, const std::vector<std::string>& keys) {
    for (const std::string& key : keys) {
      EXPECT_TRUE(std::regex_search(line, std::regex(" " + key + R"(=([^ "]+|"[^"]+")( |$))")))
          << key << " in " << line;
    }
  }

  Farm farm_;
};

TEST_F(ObservabilityTest, ATraceHasOneCompleteEventATile) {
  farm_.StartServer();
  farm_.StartWorker("one", 2);
  farm_.StartWorker("two", 1);
  farm_.WaitForWorkers(2);
  const std::string job = farm_.Submit({farm_.Scene("debris"), "--size", "270x200", "--frames", "3-4"});
  farm_.WatchUntil(job, [](const v1::Job& state) { return state.state() == v1::JOB_STATE_SUCCEEDED; });
  const Farm::Ended all = farm_.Client({"trace", job, "-o", "-", "--server", farm_.Address()});
  ASSERT_EQ(all.status, 0) << all.errors;
  const json trace = json::parse(all.output, nullptr, false);
  ASSERT_TRUE(trace.is_object()) << all.output.substr(0, 300);
  std::map<std::pair<int, int>, int> tiles;
  std::map<std::pair<int, int>, double> busy_until;  // Of each row of each worker.
  std::vector<json> events = trace["traceEvents"];
  std::stable_sort(events.begin(), events.end(),
                   [](const json& a, const json& b) { return a.value("ts", 0.0) < b.value("ts", 0.0); });
  int files = 0, commits = 0;
  for (const json& event : events) {
    if (event["ph"] != "X") continue;
    EXPECT_GE(event["dur"], 0);
    files += event["cat"] == "assembly";
    commits += event["cat"] == "commit";
    if (event["cat"] != "tile") continue;
    ++tiles[{event["args"]["frame"].get<int>(), event["args"]["tile"].get<int>()}];
    EXPECT_GT(event["args"]["lease"], 0);
    EXPECT_GE(event["args"]["received_us"].get<double>(), event["args"]["granted_us"].get<double>());
    EXPECT_GE(event["args"]["durable_us"].get<double>(), event["args"]["received_us"].get<double>());
    double& free = busy_until[{event["pid"].get<int>(), event["tid"].get<int>()}];
    EXPECT_GE(event["ts"].get<double>(), free - 1) << "two tiles at once in one row: " << event;
    free = event["ts"].get<double>() + event["dur"].get<double>();
  }
  EXPECT_EQ(tiles.size(), size_t{2 * kTiles});
  for (const auto& [tile, count] : tiles) EXPECT_EQ(count, 1) << tile.first << ", " << tile.second;
  EXPECT_EQ(files, 2);
  EXPECT_GE(commits, 2);

  const Farm::Ended one = farm_.Client({"trace", job, "--frame", "4", "-o",
                                        (farm_.folder() / "t.json").string(), "--server", farm_.Address()});
  EXPECT_EQ(one.status, 0) << one.errors;
  EXPECT_THAT(one.output, testing::HasSubstr("63 tiles"));
  EXPECT_EQ(farm_.Client({"trace", job, "--frame", "9", "-o", "-", "--server", farm_.Address()}).status, 1);
}

TEST_F(ObservabilityTest, LinesOfARealRunNameWhatTheyAreAbout) {
  farm_.StartServer();
  farm_.StartWorker("victim", 1);
  const std::string job = farm_.Submit({farm_.Scene("debris"), "--size", "270x200", "--frame", "3", "--spp",
                                        "64", "--integrator", "reference"});
  farm_.WatchUntil(job, [](const v1::Job& state) { return state.tiles_done() > 0; });
  farm_.worker("victim").Signal(SIGKILL);
  farm_.WaitForWorkers(0);
  EXPECT_TRUE(WaitUntil([&] { return !Lines(farm_.server().Errors(), "worker lost").empty(); }));
  farm_.StartWorker("heir", 2);
  farm_.WatchUntil(job, [](const v1::Job& state) { return state.state() == v1::JOB_STATE_SUCCEEDED; });
  farm_.worker("heir").Signal(SIGTERM);
  farm_.worker("heir").Wait();

  const std::string server = farm_.server().Errors();
  const std::map<std::string, std::vector<std::string>> wanted = {
      {"worker registered", {"worker", "name", "slots"}},
      {"job accepted", {"job", "frames"}},
      {"lease ran out", {"lease", "worker"}},
      {"worker lost", {"worker"}},
      {"frame finished", {"job", "frame", "bytes"}},
      {"job ended", {"job", "state"}},
      {"worker left", {"worker"}},
  };
  for (const auto& [what, keys] : wanted) {
    const std::vector<std::string> lines = Lines(server, what);
    EXPECT_FALSE(lines.empty()) << what << " is not in\n" << server;
    for (const std::string& line : lines) ExpectFields(line, keys);
  }
  // Whatever a worker says, it says who says it.
  const std::vector<std::string> lines =
      absl::StrSplit(farm_.worker("heir").Errors(), '\n', absl::SkipEmpty());
  EXPECT_GE(lines.size(), 3u);
  for (const std::string& line : lines) ExpectFields(line, {"worker"});
}

}  // namespace
}  // namespace shutterline
