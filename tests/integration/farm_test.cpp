#include "tests/integration/farm.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

namespace shutterline {
namespace {

using testing::HasSubstr;

/// Fast enough for a loaded machine, with cut tiles at two borders: 9 × 7 tiles.
const std::vector<std::string> kPicture = {"--size", "270x200", "--float", "--frame", "3"};
/// The same picture by the reference integrator, slow enough to be caught in the middle.
const std::vector<std::string> kSlowPicture = {"--size", "270x200", "--float",      "--frame",  "3",
                                               "--spp",  "64",      "--integrator", "reference"};

std::vector<std::string> Arguments(const std::string& scene, const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {scene};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

class FarmTest : public testing::Test {
 protected:
  /// The picture as `render` makes it in one process.
  std::vector<uint32_t> RenderInProcess(const std::string& scene, const std::vector<std::string>& picture,
                                        int threads) {
    const std::string file = (farm_.folder() / ("in-process-" + std::to_string(threads) + ".exr")).string();
    std::vector<std::string> arguments = Arguments(scene, picture);
    arguments.insert(arguments.begin(), "render");
    arguments.insert(arguments.end(), {"--threads", std::to_string(threads), "-o", file});
    const Farm::Ended render = farm_.Client(arguments);
    EXPECT_EQ(render.status, 0) << render.errors;
    return PixelBits(file);
  }

  std::vector<uint32_t> FetchPixels(const std::string& job) {
    const std::string file = (farm_.folder() / (job + ".exr")).string();
    farm_.Fetch(job, file);
    return PixelBits(file);
  }

  /// Something is done, but not all: whatever is killed now is killed in mid-frame.
  void WaitForMidFrame(const std::string& job, uint64_t tiles = 1) {
    const v1::Job state = farm_.WatchUntil(job, [&](const v1::Job& j) { return j.tiles_done() >= tiles; });
    ASSERT_LT(state.tiles_done(), state.tiles_total()) << "too fast to be caught in mid-frame";
  }

  Farm farm_;
};

TEST_F(FarmTest, OneWorkerTwoWorkersAndOneProcessAgreeToTheLastBit) {
  const std::string scene = farm_.Scene("debris");
  const std::vector<uint32_t> truth = RenderInProcess(scene, kPicture, 1);
  ASSERT_EQ(truth.size(), 270u * 200u * 4u);
  // Not an empty picture: something is covered, partly too.
  EXPECT_GT(std::count_if(truth.begin(), truth.end(), [](uint32_t bits) { return bits != 0; }), 1000);
  EXPECT_EQ(RenderInProcess(scene, kPicture, 2), truth);
  EXPECT_EQ(RenderInProcess(scene, kPicture, 4), truth);

  farm_.StartServer();
  farm_.StartWorker("one", 2);
  EXPECT_EQ(FetchPixels(farm_.Submit(Arguments(scene, kPicture))), truth);
  farm_.StartWorker("two", 1);
  farm_.WaitForWorkers(2);
  EXPECT_EQ(FetchPixels(farm_.Submit(Arguments(scene, kPicture))), truth);
  for (const char* order : {"center", "coarse"}) {
    std::vector<std::string> arguments = Arguments(scene, kPicture);
    arguments.insert(arguments.end(), {"--order", order});
    const std::string job = farm_.Submit(arguments);
    EXPECT_EQ(FetchPixels(job), truth) << order;
    EXPECT_THAT(farm_.Client({"status", job, "--json", "--server", farm_.Address()}).output,
                HasSubstr(absl::StrCat("\"order\": \"", order)));
  }
}

TEST_F(FarmTest, AWorkerKilledInMidFrameChangesNoPixel) {
  const std::string scene = farm_.Scene("debris");
  const std::vector<uint32_t> truth = RenderInProcess(scene, kSlowPicture, 2);
  farm_.StartServer();
  farm_.StartWorker("victim", 2);
  const std::string job = farm_.Submit(Arguments(scene, kSlowPicture));
  WaitForMidFrame(job);
  farm_.worker("victim").Signal(SIGKILL);
  EXPECT_EQ(farm_.worker("victim").Wait(), 128 + SIGKILL);
  farm_.StartWorker("second victim", 1);
  WaitForMidFrame(job, 5);
  farm_.StartWorker("heir", 1);
  farm_.WaitForWorkers(2);
  farm_.worker("second victim").Signal(SIGKILL);
  EXPECT_EQ(FetchPixels(job), truth);
}

TEST_F(FarmTest, ACoordinatorKilledInMidFrameFinishesAfterItsRestart) {
  const std::string scene = farm_.Scene("debris");
  const std::vector<uint32_t> truth = RenderInProcess(scene, kSlowPicture, 2);
  farm_.StartServer();
  const std::string job = farm_.Submit(Arguments(scene, kSlowPicture));
  // Acknowledged and not begun.
  farm_.server().Signal(SIGKILL);
  EXPECT_EQ(farm_.server().Wait(), 128 + SIGKILL);
  farm_.StartServer();
  farm_.StartWorker("one", 1);
  farm_.StartWorker("two", 1);
  WaitForMidFrame(job);
  // In mid-frame. Both workers come back by themselves.
  farm_.server().Signal(SIGKILL);
  EXPECT_EQ(farm_.server().Wait(), 128 + SIGKILL);
  farm_.StartServer();
  EXPECT_EQ(FetchPixels(job), truth);
  farm_.WaitForWorkers(2);
  EXPECT_TRUE(farm_.worker("one").Running());
  EXPECT_TRUE(farm_.worker("two").Running());
}

TEST_F(FarmTest, SigtermLetsAWorkerFinishAndLeave) {
  const std::string scene = farm_.Scene("debris");
  farm_.StartServer();
  farm_.StartWorker("leaves", 1);
  const std::string job = farm_.Submit(Arguments(scene, kSlowPicture));
  WaitForMidFrame(job);
  farm_.worker("leaves").Signal(SIGTERM);
  EXPECT_EQ(farm_.worker("leaves").Wait(), 0) << farm_.worker("leaves").Errors();
  EXPECT_THAT(farm_.worker("leaves").Errors(), HasSubstr("worker left"));
  farm_.WaitForWorkers(0);
  // Nothing is lost: what it held was delivered, what it did not get waits for another.
  farm_.StartWorker("comes", 2);
  EXPECT_EQ(FetchPixels(job), RenderInProcess(scene, kSlowPicture, 2));
  farm_.worker("comes").Signal(SIGINT);
  EXPECT_EQ(farm_.worker("comes").Wait(), 0);
  farm_.server().Signal(SIGTERM);
  EXPECT_EQ(farm_.server().Wait(), 0) << farm_.server().Errors();
}

TEST_F(FarmTest, AnIdleWorkerOutlivesTheCoordinatorAndLeavesWithoutIt) {
  farm_.StartServer();
  farm_.StartWorker("waits", 1);
  farm_.WaitForWorkers(1);
  farm_.server().Signal(SIGKILL);
  ASSERT_TRUE(
      WaitUntil([&] { return farm_.worker("waits").Errors().find("trying again") != std::string::npos; }));
  EXPECT_TRUE(farm_.worker("waits").Running());
  farm_.worker("waits").Signal(SIGTERM);
  EXPECT_EQ(farm_.worker("waits").Wait(), 0) << farm_.worker("waits").Errors();
}

TEST_F(FarmTest, AnUnchangedSceneUploadsNothing) {
  farm_.StartServer();
  const std::string scene = farm_.Scene("plane");
  for (const bool first : {true, false}) {
    std::vector<std::string> arguments = Arguments(scene, kPicture);
    arguments.insert(arguments.begin(), "submit");
    arguments.insert(arguments.end(), {"--json", "--server", farm_.Address()});
    const Farm::Ended submit = farm_.Client(arguments);
    ASSERT_EQ(submit.status, 0) << submit.errors;
    const auto json = nlohmann::json::parse(submit.output, nullptr, /*allow_exceptions=*/false);
    ASSERT_TRUE(json.is_object()) << submit.output;
    EXPECT_EQ(json["upload"]["bytes_uploaded"] == 0, !first) << submit.output;
  }
}

TEST_F(FarmTest, StatisticsComeWithTheFramesAndAgainWithTheStatus) {
  farm_.StartServer();
  farm_.StartWorker("one", 2);
  std::vector<std::string> arguments = Arguments(farm_.Scene("debris"), kPicture);
  arguments.insert(arguments.begin(), "submit");
  arguments.insert(arguments.end(), {"--wait", "-o", (farm_.folder() / "debris.exr").string(), "--stats",
                                     "--json", "--server", farm_.Address()});
  const Farm::Ended submit = farm_.Client(arguments);
  ASSERT_EQ(submit.status, 0) << submit.errors;
  const auto json = nlohmann::json::parse(submit.output, nullptr, /*allow_exceptions=*/false);
  ASSERT_TRUE(json.is_object()) << submit.output;
  const auto& total = json["stats"]["total"];
  EXPECT_EQ(total["tiles"], 63);
  EXPECT_EQ(total["tiles_total"], 63);
  EXPECT_GE(total["instants_per_line"], 1);
  EXPECT_GT(total["spans"], 0);
  EXPECT_GT(total["thread_seconds"], 0);

  const std::vector<std::string> status = {"status", json["job"]["id"].get<std::string>(), "--stats",
                                           "--server", farm_.Address()};
  const Farm::Ended text = farm_.Client(status);
  EXPECT_EQ(text.status, 0) << text.errors;
  EXPECT_THAT(text.output, HasSubstr("pattern=auto resolver=slice time_step=2 target_error=0.0025"));
  EXPECT_THAT(text.output, HasSubstr("\n      3         63"));
  const Farm::Ended again =
      farm_.Client(Arguments(status[0], {status[1], "--stats", "--json", status[3], status[4]}));
  EXPECT_EQ(nlohmann::json::parse(again.output, nullptr, false)["stats"], json["stats"]) << again.errors;
}

TEST_F(FarmTest, ABrokenSceneIsRefusedAndTheCoordinatorLives) {
  farm_.StartServer();
  const std::string broken = (farm_.folder() / "broken.gltf").string();
  {
    FILE* file = std::fopen(broken.c_str(), "w");
    ASSERT_NE(file, nullptr);
    std::fputs(R"({"asset": {"version": "2.0"}, "scene": 7, "scenes": [{"nodes": [4]}]})", file);
    std::fclose(file);
  }
  const Farm::Ended submit = farm_.Client({"submit", broken, "--server", farm_.Address()});
  EXPECT_EQ(submit.status, 1) << submit.output;
  EXPECT_THAT(submit.errors, HasSubstr("broken.gltf"));
  EXPECT_TRUE(farm_.server().Running());
  EXPECT_FALSE(farm_.Submit(Arguments(farm_.Scene("plane"), kPicture)).empty());
}

}  // namespace
}  // namespace shutterline
