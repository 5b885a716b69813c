#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/engine/scene_import/import_helpers.h"
#include "worker/engine/scene/directory_asset_source.h"

// Containers, buffers, URIs, extensions and limits.
namespace shutterline::engine::document_test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

GltfBuilder Triangle() {
  GltfBuilder file;
  file.DrawTriangle();
  return file;
}

TEST(GltfDocument, GlbDataUriAndExternalFileGiveTheSameScene) {
  const GltfBuilder file = Triangle();
  const std::string percent_encoded = "data:application/gltf-buffer," + [&] {
    std::string text;
    for (const char c : file.buffer) {
      const char* hex = "0123456789abcdef";
      text += {'%', hex[uint8_t(c) >> 4], hex[uint8_t(c) & 15]};
    }
    return text;
  }();
  const std::map<std::string, std::string> files = {{"a.glb", file.Glb()},
                                                    {"b.gltf", file.Gltf()},
                                                    {"c.gltf", file.GltfWith("sub/./x/../my%20data.bin")},
                                                    {"d.gltf", file.GltfWith(percent_encoded)},
                                                    {"e.gltf", "\xEF\xBB\xBF \n" + file.Gltf()},
                                                    {"sub/my data.bin", file.buffer}};
  for (const char* name : {"a.glb", "b.gltf", "c.gltf", "d.gltf", "e.gltf"}) {
    SCOPED_TRACE(name);
    const auto scene = ImportGltf(MemoryAssetSource(name, files));
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ((*scene)->name, name);
    EXPECT_THAT((*scene)->meshes[0].primitives[0].positions,
                ElementsAre(V3f(0, 0, 0), V3f(1, 0, 0), V3f(0, 1, 0)));
  }
}

TEST(GltfDocument, ListsExternalFilesOnceAndDecoded) {
  GltfBuilder file = Triangle();
  file.Add("images", {{"uri", "t%C3%A9x.png"}});
  file.Add("images", {{"uri", "data:image/png;base64,AAAA"}});
  file.Add("images", {{"uri", "./data.bin"}});
  const auto files = ListExternalFiles(MemoryAssetSource("a.gltf", {}), file.GltfWith("data.bin"));
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_THAT(*files, ElementsAre("data.bin", "t\xC3\xA9x.png"));
}

TEST(GltfDocument, RefusesUrisThatLeaveTheFolder) {
  const GltfBuilder file = Triangle();
  for (const char* uri : {"/etc/passwd", "../x.bin", "a/../../x.bin", "%2e%2e/x.bin", "%2Fetc/passwd",
                          "file:///x", "http://host/x.bin", "a%00b", "a%zz", "C:\\x", "."}) {
    SCOPED_TRACE(uri);
    const MemoryAssetSource source("a.gltf", {{"a.gltf", file.GltfWith(uri)}});
    const auto scene = ImportGltf(source);
    EXPECT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument) << scene.status();
    EXPECT_THAT(scene.status().message(), HasSubstr("load scene a.gltf: buffer 0: uri"));
    EXPECT_EQ(ListExternalFiles(source, file.GltfWith(uri)).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
}

TEST(GltfDocument, ADirectoryGivesItsFilesAndNoOthers) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "scene_import_directory";
  std::filesystem::create_directories(folder / "inside");
  const GltfBuilder file = Triangle();
  std::ofstream(folder / "inside" / "a.gltf", std::ios::binary) << file.GltfWith("b.bin");
  std::ofstream(folder / "inside" / "b.bin", std::ios::binary) << file.buffer;
  std::ofstream(folder / "outside.bin", std::ios::binary) << file.buffer;
  const auto source = DirectoryAssetSource::Open((folder / "inside" / "a.gltf").string());
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->RootName(), "a.gltf");
  EXPECT_TRUE(ImportGltf(**source).ok());
  EXPECT_EQ((*source)->Read("b.bin", 1000).value(), file.buffer);
  EXPECT_EQ((*source)->Read("b.bin", file.buffer.size() - 1).status().code(),
            absl::StatusCode::kResourceExhausted);
  EXPECT_EQ((*source)->Read("c.bin", 1000).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ((*source)->Read("../outside.bin", 1000).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ((*source)->Read((folder / "outside.bin").string(), 1000).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(DirectoryAssetSource::Open((folder / "nothing.glb").string()).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(DirectoryAssetSource::Open(folder.string()).status().code(), absl::StatusCode::kInvalidArgument);
  std::filesystem::remove_all(folder);
}

TEST(GltfDocument, EveryTruncationOfAGlbIsRefused) {
  const std::string glb = Triangle().Glb();
  ASSERT_TRUE(ImportBytes(glb).ok());
  for (size_t length = 0; length < glb.size(); ++length) {
    EXPECT_FALSE(ImportBytes(glb.substr(0, length)).ok()) << length << " of " << glb.size() << " bytes";
  }
  EXPECT_TRUE(ImportBytes(glb + "more").ok());  // With a warning.
}

TEST(GltfDocument, RequiredExtensionsAreRefusedByNameUnlessSupported) {
  GltfBuilder file = Triangle();
  file.json["extensionsRequired"] = {"KHR_materials_unlit", "KHR_mesh_quantization"};
  EXPECT_TRUE(ImportBytes(file.Glb()).ok());
  file.json["extensionsRequired"].push_back("KHR_draco_mesh_compression");
  const absl::Status status = MustFail(file);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented);
  EXPECT_THAT(status.message(),
              HasSubstr("load scene test.glb: extensionsRequired: KHR_draco_mesh_compression"));
}

TEST(GltfDocument, RefusesOtherVersions) {
  GltfBuilder file = Triangle();
  for (const char* version : {"1.0", "3.0", "2", ""}) {
    file.json["asset"]["version"] = version;
    EXPECT_THAT(MustFail(file).message(), HasSubstr("asset.version"));
  }
  file.json["asset"]["version"] = "2.1";
  EXPECT_TRUE(ImportBytes(file.Glb()).ok());
  file.json["asset"]["minVersion"] = "2.1";
  EXPECT_EQ(MustFail(file).code(), absl::StatusCode::kUnimplemented);
}

TEST(GltfDocument, RefusesValuesOfTheWrongKindByName) {
  const auto message = [](const char* pointer, const json& value) {
    GltfBuilder file = Triangle();
    file.json[json::json_pointer(pointer)] = value;
    return std::string(MustFail(file).message());
  };
  EXPECT_THAT(message("/accessors/0/count", -1), HasSubstr("accessor 0: count: -1 is not a whole number"));
  EXPECT_THAT(message("/accessors/0/count", 2.5), HasSubstr("accessor 0: count: 2.5 is not a whole number"));
  EXPECT_THAT(message("/accessors/0/count", "3"), HasSubstr("accessor 0: count"));
  EXPECT_THAT(message("/accessors/0/componentType", 5124), HasSubstr("5124 is none of"));
  EXPECT_THAT(message("/accessors/0/type", "VEC5"), HasSubstr("accessor 0: type: \"VEC5\" is none of"));
  EXPECT_THAT(message("/accessors/0/count", 4),
              HasSubstr("accessor 0: byteOffset 0 + 4 × 12 exceeds bufferView 0"));
  EXPECT_THAT(message("/accessors/0/count", 1ull << 53), HasSubstr("exceeds bufferView 0"));
  EXPECT_THAT(message("/accessors/0/byteOffset", 1ull << 53), HasSubstr("exceeds bufferView 0"));
  EXPECT_THAT(message("/bufferViews/0/byteStride", 8), HasSubstr("accessor 0: its elements of 12 bytes"));
  EXPECT_THAT(message("/bufferViews/0/byteStride", 14), HasSubstr("14"));
  EXPECT_THAT(message("/meshes/0/primitives/0/mode", 7),
              HasSubstr("mesh 0: primitives[0].mode: 7 is none of"));
  EXPECT_THAT(message("/nodes/0/mesh", -1), HasSubstr("node 0: mesh: -1 is not"));
  EXPECT_THAT(message("/nodes/0/matrix", json::array({1, 2})), HasSubstr("node 0: matrix: it has 2 numbers"));
  EXPECT_THAT(message("/nodes/0/scale", json::array({1, 1, 1e39})), HasSubstr("does not fit"));
  EXPECT_THAT(message("/meshes", 7), HasSubstr("meshes: 7 is not an array"));
  // Integers that are written as 3.0 are integers.
  GltfBuilder file = Triangle();
  file.json["accessors"][0]["count"] = 3.0;
  EXPECT_TRUE(ImportBytes(file.Glb()).ok());
}

TEST(GltfDocument, WhatIsNotReadMayBeAnything) {
  GltfBuilder file = Triangle();
  file.json["extras"] = {{"deep", {{{1}}}}};
  file.json["nodes"][0]["extras"] = "text";
  file.json["nodes"][0]["extensions"] = {{"VENDOR_thing", {{"index", -4}}}};
  file.json["accessors"][0]["min"] = "nonsense";
  EXPECT_TRUE(ImportBytes(file.Glb()).ok());
}

TEST(GltfDocument, DeepJsonIsRefusedBeforeAnythingRecurses) {
  for (const size_t depth : {size_t{513}, size_t{1000000}}) {
    const std::string text = "{\"asset\":" + std::string(depth, '[') + std::string(depth, ']') + "}";
    EXPECT_EQ(ImportBytes(text).status().code(), absl::StatusCode::kResourceExhausted);
  }
  // Brackets in strings are text.
  GltfBuilder file = Triangle();
  file.json["nodes"][0]["name"] = "\\\"" + std::string(2000, '[');
  EXPECT_TRUE(ImportBytes(file.Glb()).ok());
}

TEST(GltfLimits, AreHeldBeforeMemoryIsTaken) {
  // An accessor without a buffer view costs no bytes in the file.
  GltfBuilder file = Triangle();
  file.json["accessors"][0].erase("bufferView");
  for (const uint64_t count : {uint64_t{1} << 31, uint64_t{1} << 53}) {
    file.json["accessors"][0]["count"] = count;
    const absl::Status status = MustFail(file);
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
    EXPECT_THAT(status.message(), HasSubstr("mesh 0: primitive 0: vertices"));
  }
  // Within the number of vertices, but not within what so small a file may unfold into.
  file.json["accessors"][0]["count"] = uint64_t{1} << 27;
  EXPECT_THAT(MustFail(file).message(), HasSubstr("bytes of memory"));

  file = Triangle();
  ImportLimits limits;
  limits.max_triangles = 0;
  EXPECT_EQ(MustFail(file, limits).code(), absl::StatusCode::kResourceExhausted);
  limits = {};
  limits.max_nodes = 2;
  EXPECT_TRUE(ImportBytes(file.Glb(), limits).ok());
  for (int i = 0; i < 2; ++i) file.Add("nodes", json::object());
  EXPECT_THAT(MustFail(file, limits).message(), HasSubstr("nodes: 3 elements, more than the limit of 2"));
  limits = {};
  limits.max_file_bytes = file.Glb().size() - 1;
  EXPECT_EQ(MustFail(file, limits).code(), absl::StatusCode::kResourceExhausted);
}

TEST(GltfLimits, DrawingOneMeshManyTimesIsBounded) {
  // 4,000 triangles, stored once, by 50,000 nodes: 200 million triangles to draw.
  GltfBuilder file;
  const int positions = file.AccessorOn(-1, 0, "VEC3", 5126, 12'000);
  const int mesh = file.Mesh({{"attributes", {{"POSITION", positions}}}});
  file.Draw(mesh);
  json children = json::array();
  for (int i = 0; i < 50'000; ++i) children.push_back(file.Add("nodes", {{"mesh", mesh}}));
  file.json["nodes"][0]["children"] = children;
  ImportLimits limits;
  limits.drawn_per_file_byte = 0;
  const absl::Status status = MustFail(file, limits);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(status.message(), HasSubstr("drawn more than"));
  // Exactly as many as are allowed.
  GltfBuilder few;
  const int small = few.Mesh({{"attributes", {{"POSITION", few.AccessorOn(-1, 0, "VEC3", 5126, 30)}}}});
  few.Draw(small);
  few.Draw(small);
  limits.base_drawn = 60;
  EXPECT_TRUE(ImportBytes(few.Glb(), limits).ok());
  limits.base_drawn = 59;
  EXPECT_THAT(MustFail(few, limits).message(), HasSubstr("30 vertices drawn"));
}

TEST(GltfLimits, ValuesOfTheJsonAreCountedBeforeTheyAreRead) {
  GltfBuilder file;
  file.DrawTriangle();
  json extras = json::array();
  for (int i = 0; i < 1000; ++i) extras.push_back(json::array());
  file.json["extras"] = extras;
  ImportLimits limits;
  EXPECT_TRUE(ImportBytes(file.Glb(), limits).ok());
  limits.max_json_values = 1000;
  EXPECT_THAT(MustFail(file, limits).message(), HasSubstr("values, more than the limit of 1000"));
}

TEST(GltfLimits, SharingOneLargeAccessorManyTimesIsBounded) {
  GltfBuilder file;
  const int positions = file.AccessorOn(-1, 0, "VEC3", 5126, 1 << 20);
  json primitives = json::array();
  for (int i = 0; i < 1000; ++i) primitives.push_back({{"attributes", {{"POSITION", positions}}}});
  file.Draw(file.Add("meshes", {{"primitives", primitives}}));
  EXPECT_EQ(MustFail(file).code(), absl::StatusCode::kResourceExhausted);
}

}  // namespace
}  // namespace shutterline::engine::document_test
