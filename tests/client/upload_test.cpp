#include "client/upload.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "client/scene_manifest.h"
#include "client/scene_source.h"
#include "common/image/exr.h"
#include "tests/client/fake_farm.h"
#include "tests/client/temp_folder.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine/scene/environment.h"

namespace shutterline::client::upload_test {
namespace {

/// A scene of two buffers and a picture, which need not hold anything that can be drawn.
std::string Gltf(const std::string& first_uri, size_t bytes) {
  return R"({"asset":{"version":"2.0"},"buffers":[{"uri":")" + first_uri + R"(","byteLength":)" +
         std::to_string(bytes) + R"(},{"uri":"sub/b%20c.bin","byteLength":)" + std::to_string(bytes) +
         R"(},{"uri":"data:application/octet-stream;base64,AAAA","byteLength":3}],)" +
         R"("images":[{"uri":"tex.png"}]})";
}

std::unique_ptr<engine::DirectoryAssetSource> Open(const TempFolder& folder) {
  auto source = engine::DirectoryAssetSource::Open(folder.File("scene.gltf"));
  EXPECT_TRUE(source.ok()) << source.status();
  return *std::move(source);
}

void WriteScene(const TempFolder& folder, size_t bytes, uint32_t seed) {
  std::mt19937 random(seed);
  std::string data(bytes, '\0');
  folder.Write("scene.gltf", Gltf("a.bin", bytes));
  for (const char* name : {"a.bin", "sub/b c.bin", "tex.png"}) {
    for (char& c : data) c = char(random());
    folder.Write(name, data);
  }
}

TEST(Manifest, AnEnvironmentTravelsUnderItsOwnName) {
  TempFolder folder;
  folder.Write("scene.gltf", R"({"asset": {"version": "2.0"}})");
  Image sky(8, 4, {"R", "G", "B"});
  folder.Write("noon.exr", *EncodeExr(sky, {}, {}));
  folder.Write("wrong.exr", *EncodeExr(Image(8, 8, {"R", "G", "B"}), {}, {}));
  const auto source = OpenSceneSource(folder.File("scene.gltf"), folder.File("noon.exr"));
  ASSERT_TRUE(source.ok()) << source.status();
  const auto manifest = BuildManifest(**source, 1 << 20);
  ASSERT_TRUE(manifest.ok()) << manifest.status();
  ASSERT_EQ(manifest->files.size(), 2u);
  EXPECT_EQ(manifest->files[1].name, std::string(engine::kEnvironmentFile));
  // None was given: one that lies beside the scene is not taken.
  folder.Write(std::string(engine::kEnvironmentFile), "anything");
  const auto bare = OpenSceneSource(folder.File("scene.gltf"), "");
  ASSERT_TRUE(bare.ok());
  EXPECT_EQ(BuildManifest(**bare, 1 << 20)->files.size(), 1u);
  // What is wrong is told before anything travels.
  const auto wrong = OpenSceneSource(folder.File("scene.gltf"), folder.File("wrong.exr"));
  ASSERT_TRUE(wrong.ok());
  EXPECT_EQ(BuildManifest(**wrong, 1 << 20).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(OpenSceneSource(folder.File("scene.gltf"), folder.File("none.exr")).status().code(),
            absl::StatusCode::kNotFound);
}

TEST(SceneManifest, NamesEveryFileOnceWithItsDigest) {
  TempFolder folder;
  WriteScene(folder, 1000, 1);
  const auto manifest = BuildManifest(*Open(folder), 1 << 20);
  ASSERT_TRUE(manifest.ok()) << manifest.status();
  EXPECT_EQ(manifest->root_name, "scene.gltf");
  ASSERT_EQ(manifest->files.size(), 4u);
  EXPECT_EQ(manifest->files[0].name, "scene.gltf");
  for (const char* name : {"scene.gltf", "a.bin", "sub/b c.bin", "tex.png"}) {
    const SceneFile* file = manifest->Find(name);
    ASSERT_NE(file, nullptr) << name;
    EXPECT_EQ(file->digest, Sha256(folder.Read(name))) << name;
    EXPECT_EQ(file->size, folder.Read(name).size()) << name;
  }
}

TEST(SceneManifest, RefusesUrisThatLeaveTheFolder) {
  for (const char* uri : {"../secret.bin", "/etc/passwd", "sub/../../secret.bin", "%2e%2e/secret.bin",
                          "http://example.com/a.bin", "file:///etc/passwd", "a\\\\..\\\\b.bin"}) {
    TempFolder outer;
    outer.Write("secret.bin", "secret");
    outer.Write("in/scene.gltf", Gltf(uri, 6));
    outer.Write("in/sub/b c.bin", "abcdef");
    outer.Write("in/tex.png", "x");
    auto source = engine::DirectoryAssetSource::Open(outer.File("in/scene.gltf"));
    ASSERT_TRUE(source.ok());
    const auto manifest = BuildManifest(**source, 1 << 20);
    EXPECT_EQ(manifest.status().code(), absl::StatusCode::kInvalidArgument) << uri << manifest.status();
    EXPECT_NE(manifest.status().message().find("scene.gltf"), absl::string_view::npos) << manifest.status();
  }
}

TEST(SceneManifest, NamesTheFileThatIsMissingOrTooLarge) {
  TempFolder folder;
  WriteScene(folder, 5000, 1);
  auto manifest = BuildManifest(*Open(folder), 4999);
  EXPECT_EQ(manifest.status().code(), absl::StatusCode::kResourceExhausted) << manifest.status();
  std::filesystem::remove(folder.File("tex.png"));
  manifest = BuildManifest(*Open(folder), 1 << 20);
  EXPECT_EQ(manifest.status().code(), absl::StatusCode::kNotFound) << manifest.status();
  EXPECT_NE(manifest.status().message().find("tex.png"), absl::string_view::npos);
}

TEST(Upload, UnchangedSceneSendsNothing) {
  TempFolder folder;
  WriteScene(folder, 200'000, 1);
  FakeFarm farm;
  const auto connection = farm.Connect();
  const auto source = Open(folder);
  const auto manifest = BuildManifest(*source, 1 << 20);
  ASSERT_TRUE(manifest.ok()) << manifest.status();

  const auto first = Upload(*connection, *source, *manifest);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->files_uploaded, 4);
  EXPECT_EQ(first->bytes_uploaded, first->bytes);
  EXPECT_EQ(farm.bytes_received, first->bytes);
  EXPECT_EQ(farm.blobs.size(), 4u);

  const auto second = Upload(*connection, *source, *manifest);
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(second->bytes_uploaded, 0u);
  EXPECT_EQ(farm.bytes_received, first->bytes);
  EXPECT_NE(Describe(*second).find("0 bytes uploaded"), std::string::npos) << Describe(*second);
}

TEST(Upload, ResumesWhereverTheStreamIsCut) {
  const uint32_t seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 5; ++round) {
    TempFolder folder;
    WriteScene(folder, 300'000, random());
    FakeFarm farm;
    for (int i = 0; i < 6; ++i) {
      farm.cuts.push_back(std::uniform_int_distribution<uint64_t>(0, 200'000)(random));
    }
    farm.unavailable_calls = 2;
    const auto source = Open(folder);
    const auto manifest = BuildManifest(*source, 1 << 20);
    ASSERT_TRUE(manifest.ok());
    uint64_t told = 0, total = 0;
    const auto report = Upload(*farm.Connect(), *source, *manifest, [&](uint64_t sent, uint64_t all) {
      told = sent;
      total = all;
    });
    ASSERT_TRUE(report.ok()) << report.status();
    EXPECT_EQ(farm.bytes_received, report->bytes) << "no byte is stored twice";
    EXPECT_EQ(farm.blobs.size(), 4u);
    EXPECT_EQ(total, report->bytes);
    EXPECT_EQ(told, total);
  }
}

TEST(Upload, EmptyFilesAndEqualFilesAreSentOnce) {
  TempFolder folder;
  folder.Write("scene.gltf", Gltf("a.bin", 0));
  folder.Write("a.bin", "");
  folder.Write("sub/b c.bin", "");
  folder.Write("tex.png", "x");
  FakeFarm farm;
  const auto source = Open(folder);
  SceneManifest manifest{"scene.gltf", {}};
  for (const char* name : {"scene.gltf", "a.bin", "sub/b c.bin", "tex.png"}) {
    manifest.files.push_back({name, Sha256(folder.Read(name)), folder.Read(name).size()});
  }
  const auto report = Upload(*farm.Connect(), *source, manifest);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->files, 4);
  EXPECT_EQ(report->files_uploaded, 3) << "the two empty ones are one blob";
  EXPECT_EQ(farm.blobs.size(), 3u);
}

TEST(Upload, AFileThatChangesMeanwhileIsNamed) {
  TempFolder folder;
  WriteScene(folder, 1000, 1);
  FakeFarm farm;
  const auto source = Open(folder);
  const auto manifest = BuildManifest(*source, 1 << 20);
  ASSERT_TRUE(manifest.ok());
  folder.Write("tex.png", "changed");
  const auto report = Upload(*farm.Connect(), *source, *manifest);
  EXPECT_EQ(report.status().code(), absl::StatusCode::kAborted) << report.status();
  EXPECT_NE(report.status().message().find("tex.png"), absl::string_view::npos);
}

}  // namespace
}  // namespace shutterline::client::upload_test
