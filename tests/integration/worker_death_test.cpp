// Workers whose process dies while it renders: what the coordinator comes to know of it.
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "tests/integration/farm.h"

namespace shutterline {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// One tile, which takes long enough to die at.
const std::vector<std::string> kOneTile = {"--size",       "32x32",     "--float", "--frame", "12",
                                           "--integrator", "reference", "--spp",   "20000"};

class WorkerDeathTest : public testing::Test {
 protected:
  void SetUp() override {
    farm_.StartServer();
    farm_.worker_flags = {"--log-level", "debug"};
  }

  std::string SubmitOneTile() {
    std::vector<std::string> arguments = {farm_.Scene("fan")};
    arguments.insert(arguments.end(), kOneTile.begin(), kOneTile.end());
    return farm_.Submit(arguments);
  }

  /// The process that renders; 0 where there is none now.
  static int ChildOf(const Process& supervisor) {
    int pid = 0;
    const std::string children =
        ReadWholeFile(absl::StrCat("/proc/", supervisor.pid(), "/task/", supervisor.pid(), "/children"));
    return absl::SimpleAtoi(children.substr(0, children.find(' ')), &pid) ? pid : 0;
  }

  static size_t Count(const std::string& text, const std::string& part) {
    size_t count = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
  }

  /// Waits until the worker is at a tile for the `nth` time, and ends its process by a signal.
  void KillInMidTile(const std::string& name, size_t nth, int signal) {
    Process& worker = farm_.worker(name);
    ASSERT_TRUE(WaitUntil([&] { return Count(worker.Errors(), "tile begins") >= nth; })) << worker.Errors();
    const int child = ChildOf(worker);
    ASSERT_GT(child, 0);
    ASSERT_EQ(kill(child, signal), 0);
  }

  Farm farm_;
};

TEST_F(WorkerDeathTest, QuarantinedTileNamesSignalsAndLastLinesOfTheWorkersThatDiedOfIt) {
  const std::string job = SubmitOneTile();
  const int signals[] = {SIGSEGV, SIGKILL, SIGABRT};
  for (int i = 0; i < 3; ++i) {
    const std::string name = absl::StrCat("victim-", i);
    farm_.StartWorker(name, 1);
    KillInMidTile(name, 1, signals[i]);
    // It comes back by itself, and says what it died of. Others then get the tile.
    Process& worker = farm_.worker(name);
    ASSERT_TRUE(WaitUntil([&] { return Count(worker.Errors(), "registered epoch") == 2; }))
        << worker.Errors();
    worker.Signal(SIGTERM);
    // Alone on the farm, it may be at the tile again. Two signals that are alike might become one.
    worker.Signal(SIGINT);
    worker.Wait();
  }
  const Farm::Ended watch = farm_.Client({"watch", job, "--server", farm_.Address()});
  EXPECT_EQ(watch.status, 1) << watch.output;
  const json status =
      json::parse(farm_.Client({"status", job, "--json", "--server", farm_.Address()}).output);
  ASSERT_EQ(status["quarantined"].size(), 1u) << status;
  std::vector<std::string> seen;
  for (const json& trouble : status["quarantined"][0]["evidence"]) {
    if (trouble["signal"].is_null()) continue;  // Of one that was told to leave at once.
    seen.push_back(trouble["signal"]);
    EXPECT_THAT(trouble["log_tail"].get<std::string>(), HasSubstr(absl::StrCat("tile begins job=", job)));
    EXPECT_THAT(trouble["reason"].get<std::string>(), HasSubstr(seen.back()));
  }
  EXPECT_THAT(seen, testing::ElementsAre("SIGSEGV", "SIGKILL", "SIGABRT")) << status;
  const std::string shown = farm_.Client({"status", job, "--server", farm_.Address()}).output;
  EXPECT_THAT(shown, HasSubstr("tile begins job="));
  const std::string log = farm_.Client({"logs", job, "--server", farm_.Address()}).output;
  EXPECT_THAT(log, HasSubstr("signal=SIGABRT log_tail="));
}

TEST_F(WorkerDeathTest, WorkerThatDiesComesBackAndFinishesTheFrame) {
  const std::string scene = farm_.Scene("fan"), alone = farm_.folder() / "alone.exr";
  const std::vector<std::string> picture = {"--size",       "160x96",    "--float", "--frame", "12",
                                            "--integrator", "reference", "--spp",   "256"};
  std::vector<std::string> render = {"render", scene, "-o", alone};
  render.insert(render.end(), picture.begin(), picture.end());
  ASSERT_EQ(farm_.Client(render).status, 0);
  std::vector<std::string> submit = {scene};
  submit.insert(submit.end(), picture.begin(), picture.end());
  const std::string job = farm_.Submit(submit);
  farm_.StartWorker("w", 2);
  KillInMidTile("w", 3, SIGBUS);
  const std::string file = farm_.folder() / "farm.exr";
  farm_.Fetch(job, file);
  EXPECT_TRUE(PixelBits(file) == PixelBits(alone));
  // And leaves as it would have.
  farm_.worker("w").Signal(SIGTERM);
  EXPECT_EQ(farm_.worker("w").Wait(), 0);
  EXPECT_THAT(farm_.worker("w").Errors(), HasSubstr("worker left"));
}

TEST_F(WorkerDeathTest, ProcessThatRendersDiesWithItsSupervisor) {
  farm_.StartWorker("w", 1);
  farm_.WaitForWorkers(1);
  const int child = ChildOf(farm_.worker("w"));
  ASSERT_GT(child, 0);
  farm_.KillWorker("w");
  EXPECT_TRUE(WaitUntil([&] {
    const std::string status = ReadWholeFile(absl::StrCat("/proc/", child, "/status"));
    return status.empty() || status.find("State:\tZ") != std::string::npos;
  }));
  farm_.WaitForWorkers(0);
}

TEST_F(WorkerDeathTest, WithoutASupervisorThereIsOneProcess) {
  farm_.worker_flags.emplace_back("--no-supervise");
  farm_.StartWorker("w", 1);
  farm_.WaitForWorkers(1);
  EXPECT_EQ(ChildOf(farm_.worker("w")), 0);
  farm_.worker("w").Signal(SIGSEGV);
  EXPECT_EQ(farm_.worker("w").Wait(), 128 + SIGSEGV);
}

}  // namespace
}  // namespace shutterline
