#include "client/upload.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <string>
#include <vector>

#include "client/scene_files.h"
#include "client/scene_source.h"
#include "common/image/exr.h"
#include "proto/convert/job_spec.h"
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

absl::StatusOr<SceneFiles> ReadScene(const TempFolder& folder, const std::string& environment = "",
                                     const SceneFiles::Limits& limits = {}) {
  auto source =
      OpenSceneSource(folder.File("scene.gltf"), environment.empty() ? "" : folder.File(environment));
  if (!source.ok()) return source.status();
  return SceneFiles::Read(*std::move(source), limits);
}

constexpr SceneFiles::Limits kKeepNothing{.max_kept_bytes = 0};

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
  const auto files = ReadScene(folder, "noon.exr");
  ASSERT_TRUE(files.ok()) << files.status();
  ASSERT_EQ(files->manifest().files.size(), 2u);
  EXPECT_EQ(files->manifest().files[1].name, std::string(engine::kEnvironmentFile));
  // None was given: one that lies beside the scene is not taken.
  folder.Write(std::string(engine::kEnvironmentFile), "anything");
  EXPECT_EQ(ReadScene(folder)->manifest().files.size(), 1u);
  // What is wrong is told before anything travels.
  const auto wrong = ReadScene(folder, "wrong.exr");
  EXPECT_EQ(wrong.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(wrong.status().message().find("load scene scene.gltf: environment: "), absl::string_view::npos)
      << wrong.status();
  EXPECT_EQ(OpenSceneSource(folder.File("scene.gltf"), folder.File("none.exr")).status().code(),
            absl::StatusCode::kNotFound);
}

TEST(SceneManifest, NamesEveryFileOnceWithItsDigest) {
  TempFolder folder;
  WriteScene(folder, 1000, 1);
  const auto files = ReadScene(folder);
  ASSERT_TRUE(files.ok()) << files.status();
  const SceneManifest& manifest = files->manifest();
  EXPECT_EQ(manifest.root_name, "scene.gltf");
  ASSERT_EQ(manifest.files.size(), 4u);
  EXPECT_EQ(manifest.files[0].name, "scene.gltf");
  for (const char* name : {"scene.gltf", "a.bin", "sub/b c.bin", "tex.png"}) {
    const SceneFile* file = manifest.Find(name);
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
    const auto files = SceneFiles::Read(*std::move(source), {});
    EXPECT_EQ(files.status().code(), absl::StatusCode::kInvalidArgument) << uri << files.status();
    EXPECT_NE(files.status().message().find("scene.gltf"), absl::string_view::npos) << files.status();
  }
}

TEST(SceneManifest, NamesTheFileThatIsMissingOrTooLarge) {
  TempFolder folder;
  WriteScene(folder, 5000, 1);
  absl::Status status = ReadScene(folder, "", {.max_file_bytes = 4999}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_NE(status.message().find("a.bin"), absl::string_view::npos) << status;
  std::filesystem::remove(folder.File("tex.png"));
  status = ReadScene(folder).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound) << status;
  EXPECT_NE(status.message().find("tex.png"), absl::string_view::npos);
}

TEST(Upload, UnchangedSceneSendsNothing) {
  TempFolder folder;
  WriteScene(folder, 200'000, 1);
  FakeFarm farm;
  const auto connection = farm.Connect();
  auto files = ReadScene(folder);
  ASSERT_TRUE(files.ok()) << files.status();

  const auto first = Upload(*connection, *files);
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->files_uploaded, 4);
  EXPECT_EQ(first->bytes_uploaded, first->bytes);
  EXPECT_EQ(farm.bytes_received, first->bytes);
  EXPECT_EQ(farm.blobs.size(), 4u);

  const auto second = Upload(*connection, *files);
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
    WriteScene(folder, 1'200'000, random());  // Several chunks.
    FakeFarm farm;
    for (int i = 0; i < 6; ++i) {
      farm.cuts.push_back(std::uniform_int_distribution<uint64_t>(0, 900'000)(random));
    }
    farm.unavailable_calls = 2;
    auto files = ReadScene(folder, "", round % 2 == 0 ? SceneFiles::Limits() : kKeepNothing);
    ASSERT_TRUE(files.ok());
    uint64_t told = 0, total = 0;
    const auto report = Upload(*farm.Connect(), *files, [&](uint64_t sent, uint64_t all) {
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

TEST(Upload, OverALinkThatLetsNoLargeChunkThroughSmallerOnesCome) {
  TempFolder folder;
  WriteScene(folder, 150'000, 1);
  FakeFarm farm;
  farm.whole_chunks = true;
  farm.cuts.assign(50, 40'000);  // A stream.
  auto files = ReadScene(folder);
  ASSERT_TRUE(files.ok()) << files.status();
  const auto report = Upload(*farm.Connect(), *files);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(farm.blobs.size(), 4u);
  EXPECT_FALSE(farm.cuts.empty()) << "it got through while streams were cut";
}

TEST(Upload, EmptyFilesAndEqualFilesAreSentOnce) {
  TempFolder folder;
  folder.Write("scene.gltf", Gltf("a.bin", 0));
  folder.Write("a.bin", "");
  folder.Write("sub/b c.bin", "");
  folder.Write("tex.png", "x");
  FakeFarm farm;
  auto files = ReadScene(folder);
  ASSERT_TRUE(files.ok()) << files.status();
  const auto report = Upload(*farm.Connect(), *files);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->files, 4);
  EXPECT_EQ(report->files_uploaded, 3) << "the two empty ones are one blob";
  EXPECT_EQ(farm.blobs.size(), 3u);
}

TEST(Upload, FilesThatAreKeptAreThoseThatWereHashed) {
  TempFolder folder;
  WriteScene(folder, 1000, 1);
  FakeFarm farm;
  auto files = ReadScene(folder);
  ASSERT_TRUE(files.ok()) << files.status();
  std::set<std::string> named;
  for (const SceneFile& file : files->manifest().files) named.insert(convert::ToProto(file.digest).sha256());
  for (const char* name : {"scene.gltf", "a.bin", "sub/b c.bin"}) folder.Write(name, "changed");
  std::filesystem::remove(folder.File("tex.png"));
  const auto report = Upload(*farm.Connect(), *files);
  ASSERT_TRUE(report.ok()) << report.status();
  std::set<std::string> stored;
  for (const auto& [digest, bytes] : farm.blobs) stored.insert(digest);
  EXPECT_EQ(stored, named);
}

TEST(Upload, AFileThatChangesBeforeItIsReadAgainIsNamed) {
  // Other bytes, fewer and more.
  for (const size_t bytes : {1000, 7, 5000}) {
    SCOPED_TRACE(bytes);
    TempFolder folder;
    WriteScene(folder, 1000, 1);
    FakeFarm farm;
    auto files = ReadScene(folder, "", kKeepNothing);
    ASSERT_TRUE(files.ok()) << files.status();
    folder.Write("tex.png", std::string(bytes, 'x'));
    const auto report = Upload(*farm.Connect(), *files);
    EXPECT_EQ(report.status().code(), absl::StatusCode::kAborted) << report.status();
    EXPECT_NE(report.status().message().find("file 'tex.png' has changed"), absl::string_view::npos)
        << report.status();
    EXPECT_EQ(farm.blobs.size(), 3u) << "those before it are there, to be found at the next attempt";
  }
}

TEST(SceneFiles, WhatDoesNotFitIsReadAgainAndNothingElse) {
  TempFolder folder;
  WriteScene(folder, 1000, 1);
  // Room for one of the three files of 1000 bytes, and for the root.
  auto files = ReadScene(folder, "", {.max_kept_bytes = 1900});
  ASSERT_TRUE(files.ok()) << files.status();
  std::vector<std::string> wanted;
  for (const SceneFile& file : files->manifest().files) wanted.push_back(folder.Read(file.name));
  for (const char* name : {"scene.gltf", "a.bin"}) std::filesystem::remove(folder.File(name));
  for (size_t i = 0; i < wanted.size(); ++i) {
    const auto bytes = files->Take(files->manifest().files[i]);
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    EXPECT_EQ(*bytes, wanted[i]);
  }
  EXPECT_EQ(files->Take(files->manifest().files[1]).status().code(), absl::StatusCode::kNotFound)
      << "what was taken is not kept any longer";
}

}  // namespace
}  // namespace shutterline::client::upload_test
