#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/engine/scene_import/import_helpers.h"
#include "tests/scenes/png_picture.h"

// Which primitives get tangents, and from where.
namespace shutterline::engine::tangents_test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A quad of two triangles with normals, a picture upright on it and a normal texture.
struct NormalMapped : GltfBuilder {
  NormalMapped() {
    attributes = {{"POSITION", Floats("VEC3", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0})},
                  {"NORMAL", Floats("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1})},
                  {"TEXCOORD_0", Floats("VEC2", {0, 1, 1, 1, 1, 0, 0, 0})}};
    indices = Indices({0, 1, 2, 0, 2, 3});
    Add("materials", {{"normalTexture", {{"index", 0}}}});
    Add("textures", {{"source", 0}});
    Add("images", {{"bufferView", View(scenes::EncodePng({1, 1, 3, 8, {128, 128, 255}}))}});
  }
  std::vector<V4f> Import(const ImportLimits& limits = {}) {
    const auto scene = ImportBytes(Whole().Glb(), limits);
    EXPECT_TRUE(scene.ok()) << scene.status();
    if (!scene.ok()) return {};
    warnings = (*scene)->report.warnings;
    return (*scene)->meshes[0].primitives[0].tangents;
  }
  GltfBuilder Whole() const {
    GltfBuilder file = *this;
    file.Draw(file.Mesh({{"attributes", attributes}, {"indices", indices}, {"material", 0}}));
    return file;
  }

  nlohmann::json attributes;
  int indices;
  std::vector<std::string> warnings;
};

TEST(GltfTangents, AreMadeWhereAFileHasNone) {
  NormalMapped file;
  EXPECT_EQ(file.Import(), std::vector<V4f>(6, V4f(1, 0, 0, 1)));
}

TEST(GltfTangents, AreTakenFromTheFileByCorner) {
  NormalMapped file;
  file.attributes["TANGENT"] =
      file.Floats("VEC4", {0, 1, 0, 1, 0.6f, 0.8f, 0, -1, 1, 0, 0, 1, 0.5f, 0.5f, 0.5f, -0.25f});
  const V4f a(0, 1, 0, 1), b(0.6f, 0.8f, 0, -1), c(1, 0, 0, 1), d(0.5f, 0.5f, 0.5f, -1);
  EXPECT_THAT(file.Import(), ElementsAre(a, b, c, a, c, d));
}

TEST(GltfTangents, MayBeNormalizedIntegers) {
  NormalMapped file;
  file.attributes["TANGENT"] = file.Accessor<int8_t>(
      "VEC4", 5120, {127, 0, 0, 127, 0, 127, 0, -127, 0, -128, 0, 127, 0, 0, 127, 127}, true);
  const std::vector<V4f> tangents = file.Import();
  EXPECT_EQ(tangents[0], V4f(1, 0, 0, 1));
  EXPECT_EQ(tangents[1], V4f(0, 1, 0, -1));
  EXPECT_EQ(tangents[2], V4f(0, -1, 0, 1));
}

TEST(GltfTangents, ThatAreNoNumbersBecomeZero) {
  NormalMapped file;
  const float nan = std::nanf("");
  file.attributes["TANGENT"] = file.Floats(
      "VEC4", {1, 0, 0, 1, nan, 0, 0, 1, 1, 0, 0, std::numeric_limits<float>::infinity(), 1, 0, 0, 1});
  const std::vector<V4f> tangents = file.Import();
  EXPECT_EQ(tangents[1], V4f(0, 0, 0, 1));
  EXPECT_EQ(tangents[2], V4f(0, 0, 0, 1));
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_THAT(file.warnings[0], HasSubstr("mesh 0 primitive 0: TANGENT of 2 vertices, the first of them 1"));
}

TEST(GltfTangents, GoWithTheTrianglesThatAreLeft) {
  NormalMapped file;
  const float nan = std::nanf("");
  file.attributes["POSITION"] = file.Floats("VEC3", {0, 0, 0, nan, 0, 0, 1, 1, 0, 0, 1, 0});
  file.attributes["TANGENT"] = file.Floats("VEC4", {1, 0, 0, 1, 1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1});
  EXPECT_THAT(file.Import(), ElementsAre(V4f(1, 0, 0, 1), V4f(0, 1, 0, 1), V4f(0, 0, 1, 1)));
}

TEST(GltfTangents, WithoutNormalsAreMadeWhateverTheFileHas) {
  NormalMapped file;
  file.attributes["TANGENT"] = file.Floats("VEC4", std::vector<float>(16, 0.5f));
  file.attributes.erase("NORMAL");
  EXPECT_EQ(file.Import(), std::vector<V4f>(6, V4f(1, 0, 0, 1)));
}

TEST(GltfTangents, UseTheSetOfTheNormalTexture) {
  NormalMapped file;
  file.attributes["TEXCOORD_1"] = file.Floats("VEC2", {0, 0, 0, 1, 1, 1, 1, 0});
  json& info = file.json["materials"][0]["normalTexture"];
  info["texCoord"] = 1;
  EXPECT_EQ(file.Import(), std::vector<V4f>(6, V4f(0, 1, 0, 1)));
  // A transform may name another set; what else it says does not enter.
  info["extensions"]["KHR_texture_transform"] = {{"texCoord", 0}, {"rotation", 1}, {"scale", {-1, 1}}};
  EXPECT_EQ(file.Import(), std::vector<V4f>(6, V4f(1, 0, 0, 1)));
}

TEST(GltfTangents, AreOnlyWhereANormalTextureShows) {
  const auto with = [](const auto& change) {
    NormalMapped file;
    file.attributes["TANGENT"] = file.Floats("VEC4", std::vector<float>(16, 0.5f));
    change(file);
    return file.Import();
  };
  EXPECT_EQ(with([](NormalMapped&) {}).size(), 6u);
  EXPECT_THAT(with([](NormalMapped& file) { file.attributes.erase("TEXCOORD_0"); }), IsEmpty());
  EXPECT_THAT(with([](NormalMapped& file) { file.json["materials"][0].erase("normalTexture"); }), IsEmpty());
  EXPECT_THAT(with([](NormalMapped& file) { file.json["textures"][0].erase("source"); }), IsEmpty());
  EXPECT_THAT(with([](NormalMapped& file) {
                file.json["materials"][0]["extensions"]["KHR_materials_unlit"] = json::object();
              }),
              IsEmpty());
}

TEST(GltfTangents, AreCheckedAndLimited) {
  NormalMapped wrong;
  wrong.attributes["TANGENT"] = wrong.Floats("VEC3", std::vector<float>(12, 1.f));
  EXPECT_THAT(MustFail(wrong.Whole()).message(),
              HasSubstr("mesh 0: primitive 0: accessor 4 (TANGENT): elements of 3 components"));
  NormalMapped few;
  few.attributes["TANGENT"] = few.Floats("VEC4", std::vector<float>(12, 1.f));
  EXPECT_THAT(MustFail(few.Whole()).message(), HasSubstr("(TANGENT): count 3 is not POSITION's 4"));

  // The meshes fit with a little to spare, their tangents do not.
  NormalMapped file;
  ImportLimits limits;
  limits.memory_per_file_byte = 0;
  limits.base_memory = 4 * (12 + 12 + 8) + 6 * 4 + 2 * 12 + 50;
  const absl::Status status = MustFail(file.Whole(), limits);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(status.message(), HasSubstr("mesh 0: tangents"));
}

}  // namespace
}  // namespace shutterline::engine::tangents_test
