// Scenes that mean harm: each fails its own job with a reason, and another job does not notice.
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/integration/farm.h"
#include "tests/support/gltf_builder.h"

namespace shutterline {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const std::vector<std::string> kHostilePicture = {"--size", "64x64", "--float", "--frame", "0"};

std::vector<std::string> Joined(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// A PNG of one bit a pixel, all black: 32 megabytes unpack from 32 kilobytes.
std::string BlackPng(uint32_t side) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp p, png_bytep data, png_size_t size) {
        static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<const char*>(data), size);
      },
      nullptr);
  png_set_IHDR(png, info, side, side, 1, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  const std::vector<uint8_t> row(side / 8 + 1, 0);
  for (uint32_t y = 0; y < side; ++y) png_write_row(png, row.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

/// A triangle with this picture on it.
GltfBuilder Textured(const std::string& png) {
  GltfBuilder file;
  file.Add("images", {{"mimeType", "image/png"}, {"bufferView", file.View(png)}});
  file.Add("textures", {{"source", 0}});
  file.Add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  const int positions = file.Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int uv = file.Floats("VEC2", {0, 0, 1, 0, 0, 1});
  file.Draw(file.Mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uv}}}, {"material", 0}}));
  return file;
}

/// `count` nodes that draw one mesh of a thousand triangles.
GltfBuilder Instanced(int count) {
  GltfBuilder file;
  std::vector<float> corners;
  for (int i = 0; i < 1000; ++i) {
    const float x = float(i % 100), y = float(i / 100);
    corners.insert(corners.end(), {x, y, 0, x + 1, y, 0, x, y + 1, 0});
  }
  const int mesh = file.Mesh({{"attributes", {{"POSITION", file.Floats("VEC3", corners)}}}});
  for (int i = 0; i < count; ++i) file.Draw(mesh);
  return file;
}

/// A small file whose frames take many minutes to make ready: a thousand nodes draw a mesh whose targets jump
/// at every key, and no motion follows that. Without a camera, to find one takes long as well.
GltfBuilder Slow(bool camera) {
  constexpr int kTriangles = 2'000, kTargets = 64, kNodes = 1'000, kKeys = 64;
  GltfBuilder file;
  std::mt19937 random(1);
  const auto number = [&] { return float(random() % 1000) / 1000; };
  std::vector<float> places(9 * kTriangles), times, weights;
  for (float& place : places) place = number();
  const int positions = file.Floats("VEC3", places);
  json targets = json::array();
  for (int i = 0; i < kTargets; ++i) targets.push_back({{"POSITION", positions}});
  const int mesh = file.Mesh({{"attributes", {{"POSITION", positions}}}, {"targets", targets}});
  for (int key = 0; key < kKeys; ++key) {
    times.push_back(float(key) / (24 * kKeys));
    for (int i = 0; i < kTargets; ++i) weights.push_back(number());
  }
  const int input = file.Floats("SCALAR", times), output = file.Floats("SCALAR", weights);
  json channels = json::array();
  for (int i = 0; i < kNodes; ++i) {
    const int node = file.Draw(mesh);
    channels.push_back({{"sampler", 0}, {"target", {{"node", node}, {"path", "weights"}}}});
  }
  file.Add("animations", {{"samplers", {{{"input", input}, {"output", output}, {"interpolation", "STEP"}}}},
                          {"channels", channels}});
  if (!camera) return file;
  file.Add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
  const int node = file.Add("nodes", {{"camera", 0}, {"translation", {0, 0, 3}}});
  file.json["scenes"][0]["nodes"].push_back(node);
  return file;
}

class HostileSceneTest : public testing::Test {
 protected:
  /// The pixels of a frame that the farm has rendered are those of one process.
  void ExpectFrame(const std::string& job, const std::string& scene) {
    const std::string file = farm_.folder() / "farm.exr", alone = farm_.folder() / "alone.exr";
    farm_.Fetch(job, file);
    ASSERT_EQ(farm_.Client(Joined({"render", scene, "-o", alone}, kHostilePicture)).status, 0);
    EXPECT_TRUE(PixelBits(file) == PixelBits(alone));
  }
  std::string Write(const std::string& name, const std::string& bytes) {
    const std::string file = farm_.folder() / name;
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
  /// Submits a scene that must be refused.
  std::string Refusal(const std::string& file, const std::vector<std::string>& more = {}) {
    const Farm::Ended ended =
        farm_.Client(Joined(Joined({"submit", file, "--server", farm_.Address()}, kHostilePicture), more));
    EXPECT_EQ(ended.status, 1) << file << " was taken: " << ended.output;
    return ended.errors;
  }

  Farm farm_;
};

TEST_F(HostileSceneTest, BombsAreRefusedWithAReasonWhileAnotherJobIsRendered) {
  farm_.StartServer();
  farm_.StartWorker("w", 1);
  const std::string honest = farm_.Submit(Joined({farm_.Scene("fan")}, kHostilePicture));

  std::string huge = BlackPng(8);
  const auto put_side = [&huge](size_t at, uint32_t side) {
    for (int i = 0; i < 4; ++i) huge[at + size_t(i)] = char(side >> (24 - 8 * i));
  };
  put_side(16, 60'000);
  put_side(20, 60'000);
  EXPECT_THAT(Refusal(Write("huge.glb", Textured(huge).Glb())),
              HasSubstr("image 0: its PNG header cannot be read"));
  const std::string packed = BlackPng(16'384);
  EXPECT_LT(packed.size(), size_t{100'000});
  EXPECT_THAT(Refusal(Write("packed.glb", Textured(packed).Glb())),
              HasSubstr("16384 × 16384: 268435456 pixels"));

  GltfBuilder deep;
  deep.DrawTriangle();
  for (int i = 0; i < 5'000; ++i) {
    deep.Add("nodes", json::object());
    deep.json["nodes"][size_t(i)]["children"] = json::array({i + 1});
  }
  EXPECT_THAT(Refusal(Write("deep.glb", deep.Glb())), HasSubstr("512"));
  GltfBuilder nested;
  nested.DrawTriangle();
  std::string text = nested.Gltf();
  text.insert(1, absl::StrCat("\"extras\":", std::string(100'000, '['), std::string(100'000, ']'), ","));
  EXPECT_THAT(Refusal(Write("nested.gltf", text)), HasSubstr("nested"));

  GltfBuilder counts;
  counts.Draw(
      counts.Mesh({{"attributes", {{"POSITION", counts.AccessorOn(-1, 0, "VEC3", 5126, size_t{1} << 40)}}}}));
  EXPECT_THAT(Refusal(Write("counts.glb", counts.Glb())),
              testing::AnyOf(HasSubstr("accessor 0"), HasSubstr("vertices")));
  EXPECT_THAT(Refusal(Write("many.glb", Instanced(40'000).Glb())), HasSubstr("drawn more than"));

  // An environment whose header promises four quintillion pixels.
  const std::string fan = farm_.Scene("fan"), picture = farm_.folder() / "environment.exr";
  ASSERT_EQ(farm_.Client({"render", fan, "--size", "64x32", "-o", picture}).status, 0);
  std::string exr = ReadWholeFile(picture);
  for (const char* window : {"dataWindow", "displayWindow"}) {
    const size_t at = exr.find(window);
    ASSERT_NE(at, std::string::npos);
    const size_t corner = at + std::strlen(window) + 1 + std::strlen("box2i") + 1 + 4 + 8;
    std::memcpy(&exr[corner], "\xf0\xff\xff\x7f\xf0\xff\xff\x7f", 8);
  }
  EXPECT_THAT(Refusal(fan, {"--environment", Write("hostile.exr", exr)}), HasSubstr("exr"));

  const std::string file = farm_.folder() / "honest.exr";
  farm_.Fetch(honest, file);
  EXPECT_EQ(PixelBits(file).size(), size_t{64 * 64 * 4});
  EXPECT_TRUE(farm_.server().Running());
}

TEST_F(HostileSceneTest, AWorkerWithABoundFailsTheTileThatNeedsMoreAndGoesOn) {
  farm_.StartServer();
  farm_.worker_flags = {"--memory-mb", "700", "--cache-mb", "16"};
  farm_.StartWorker("small", 1);
  // Within the limits of the importer, beyond those of this worker.
  const std::string greedy =
      farm_.Submit(Joined({Write("greedy.glb", Instanced(11'000).Glb())}, kHostilePicture));
  const std::string honest = farm_.Submit(Joined({farm_.Scene("fan")}, kHostilePicture));
  const Farm::Ended watch = farm_.Client({"watch", greedy, "--server", farm_.Address()});
  EXPECT_NE(watch.status, 0) << watch.output;
  EXPECT_THAT(watch.output + watch.errors, HasSubstr("memory"));
  const std::string file = farm_.folder() / "honest.exr";
  farm_.Fetch(honest, file);
  EXPECT_EQ(PixelBits(file).size(), size_t{64 * 64 * 4});
  EXPECT_TRUE(farm_.worker("small").Running());
}

TEST_F(HostileSceneTest, ASceneThatTakesTooLongToCheckIsRefused) {
  farm_.server_flags = {"--scene-seconds", "1.5"};
  farm_.StartServer();
  farm_.StartWorker("w", 1);
  EXPECT_THAT(Refusal(Write("slow.glb", Slow(false).Glb())),
              HasSubstr("load scene slow.glb: it took longer than the 1.5s that are allowed"));
  const std::string scene = farm_.Scene("fan");
  ExpectFrame(farm_.Submit(Joined({scene}, kHostilePicture)), scene);
}

TEST_F(HostileSceneTest, AFrameThatTakesTooLongToMakeReadyFailsItsJobAndTheNextIsRendered) {
  farm_.StartServer();
  farm_.worker_flags = {"--scene-seconds", "1.5", "--memory-mb", "2048"};
  farm_.StartWorker("w", 1);
  const std::string slow = farm_.Submit(Joined({Write("slow.glb", Slow(true).Glb())}, kHostilePicture));
  const std::string scene = farm_.Scene("fan");
  const std::string honest = farm_.Submit(Joined({scene}, kHostilePicture));
  const Farm::Ended watch = farm_.Client({"watch", slow, "--server", farm_.Address()});
  EXPECT_EQ(watch.status, 1) << watch.output;
  EXPECT_THAT(watch.output + watch.errors, HasSubstr("it took longer than the 1.5s that are allowed"));
  ExpectFrame(honest, scene);
  EXPECT_TRUE(farm_.worker("w").Running());
}

TEST_F(HostileSceneTest, WhileAFrameIsBeingMadeReadyOtherThreadsRenderOtherJobs) {
  farm_.server_flags = {"--heartbeat", "0.1"};
  farm_.StartServer();
  farm_.worker_flags = {"--scene-seconds", "0", "--memory-mb", "2048"};
  farm_.StartWorker("w", 2);
  // Of a higher priority, and with tiles for all of the credit: it is there first, and has every thread.
  std::vector<std::string> first = {
      Write("slow.glb", Slow(true).Glb()), "--priority", "5", "--size", "1024x1024", "--frame", "0"};
  const std::string slow = farm_.Submit(first);
  farm_.WatchUntil(slow, [](const v1::Job& job) { return job.workers() == 1; });
  EXPECT_EQ(farm_.Client({"priority", slow, "0", "--server", farm_.Address()}).status, 0);
  const std::string scene = farm_.Scene("fan");
  ExpectFrame(farm_.Submit(Joined({scene}, kHostilePicture)), scene);
  const Farm::Ended status = farm_.Client({"status", slow, "--json", "--server", farm_.Address()});
  EXPECT_EQ(json::parse(status.output)["tiles_done"], 0) << "it is still at it";
}

}  // namespace
}  // namespace shutterline
