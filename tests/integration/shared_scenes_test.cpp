// Every real scene and every broken file through the programs, as a user runs them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "tests/integration/farm.h"
#include "tests/support/shared_scenes.h"

namespace shutterline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// What moves in its first animation at the frame that is rendered.
const std::set<std::string> kMoving = {
    "AnimatedMorphCube", "BoxAnimated",        "CesiumMan",         "CesiumMilkTruck", "Fox",
    "MorphStressTest",   "RecursiveSkeletons", "InterpolationTest", "RodTwist",        "VintageDeskFan"};

std::vector<fs::path> SceneFiles(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".glb" || extension == ".gltf") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

class SharedScenes : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = FindSharedScenes();
    if (!folder) GTEST_SKIP() << "the shared scenes are absent: nothing is rendered";
    scenes_ = *folder;
  }

  std::vector<std::string> With(std::vector<std::string> arguments,
                                const std::vector<std::string>& more) const {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  fs::path scenes_;
  Farm farm_;
};

TEST_F(SharedScenes, AreEqualFromOneProcessAndFromTwoWorkers) {
  farm_.StartServer();
  farm_.StartWorker("one", 1);
  farm_.StartWorker("two", 2);
  farm_.WaitForWorkers(2);
  int rendered = 0;
  for (const fs::path& file : SceneFiles(scenes_)) {
    if (file.string().find("malformed") != std::string::npos) continue;
    const std::string name = file.stem().string();
    SCOPED_TRACE(name);
    // Its first clip is a STEP one, which jumps: all nine play at once.
    const std::string animation = name == "InterpolationTest" ? "all" : "";
    const std::vector<std::string> picture = With(
        {"--size", "160x120", "--float", "--frame", name == "BoxAnimated" ? "36" : "12"},
        animation.empty() ? std::vector<std::string>{} : std::vector<std::string>{"--animation", animation});
    std::vector<uint32_t> truth;
    for (const char* threads : {"1", "4"}) {
      const std::string out = (farm_.folder() / (name + "-" + threads + ".exr")).string();
      const Farm::Ended render =
          farm_.Client(With({"render", file.string(), "--threads", threads, "-o", out}, picture));
      ASSERT_EQ(render.status, 0) << render.errors;
      const std::vector<uint32_t> pixels = PixelBits(out);
      ASSERT_EQ(pixels.size(), 160u * 120u * 4u);
      if (truth.empty()) truth = pixels;
      EXPECT_TRUE(pixels == truth) << threads << " threads";
    }
    EXPECT_GT(std::count_if(truth.begin(), truth.end(), [](uint32_t bits) { return bits != 0; }), 500)
        << "an empty picture";

    const std::string fetched = (farm_.folder() / (name + "-farm.exr")).string();
    farm_.Fetch(farm_.Submit(With({file.string()}, picture)), fetched);
    EXPECT_TRUE(PixelBits(fetched) == truth) << "two workers";

    // What moves is blurred: the picture is not that of a closed shutter.
    if (kMoving.contains(name)) {
      const std::string still = (farm_.folder() / (name + "-still.exr")).string();
      ASSERT_EQ(
          farm_.Client(With({"render", file.string(), "--shutter-close", "0", "-o", still}, picture)).status,
          0);
      EXPECT_TRUE(PixelBits(still) != truth) << "nothing moves";
    }
    ++rendered;
  }
  EXPECT_GE(rendered, 18);
}

TEST_F(SharedScenes, MalformedFilesAreRefusedByNameAndTheServerLives) {
  farm_.StartServer();
  int refused = 0;
  for (const fs::path& file : SceneFiles(scenes_ / "malformed")) {
    SCOPED_TRACE(file.string());
    const std::string name = file.filename().string();
    const fs::path out = farm_.folder() / "malformed.exr";
    const Farm::Ended render = farm_.Client({"render", file.string(), "--size", "64x48", "-o", out.string()});
    if (render.status == 0) {
      EXPECT_TRUE(fs::exists(out));
    } else {
      EXPECT_EQ(render.status, 1) << "ended by a signal or with another code";
      EXPECT_THAT(render.errors, HasSubstr(name));
      EXPECT_FALSE(fs::exists(out)) << "a picture was left behind";
    }
    fs::remove(out);

    const Farm::Ended submit = farm_.Client({"submit", file.string(), "--server", farm_.Address()});
    EXPECT_EQ(submit.status, render.status) << submit.errors;
    if (submit.status != 0) {
      EXPECT_THAT(submit.errors, HasSubstr(name));
    }
    ASSERT_TRUE(farm_.server().Running());
    refused += submit.status == 1 ? 1 : 0;
  }
  EXPECT_GE(refused, 21) << "these must be refused";
  EXPECT_FALSE(farm_.Submit({farm_.Scene("plane"), "--size", "64x48"}).empty());
}

}  // namespace
}  // namespace shutterline
