#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/engine/scene_import/import_helpers.h"

namespace shutterline::engine::mesh_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Triangle = std::array<uint32_t, 3>;

const std::vector<float> kFivePoints = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0};

std::vector<Triangle> TrianglesOf(int mode, const std::vector<uint16_t>& indices) {
  GltfBuilder file;
  nlohmann::json primitive = {{"attributes", {{"POSITION", file.Floats("VEC3", kFivePoints)}}},
                              {"mode", mode}};
  if (!indices.empty()) primitive["indices"] = file.Indices(indices);
  file.Draw(file.Mesh(primitive));
  const auto scene = MustImport(file);
  return scene->meshes.empty() ? std::vector<Triangle>() : scene->meshes[0].primitives[0].triangles;
}

TEST(GltfMesh, CutsListsStripsAndFans) {
  EXPECT_THAT(TrianglesOf(4, {}), ElementsAre(Triangle{0, 1, 2}));  // Two corners are left over.
  EXPECT_THAT(TrianglesOf(4, {2, 1, 0, 1, 3, 2}), ElementsAre(Triangle{2, 1, 0}, Triangle{1, 3, 2}));
  EXPECT_THAT(TrianglesOf(5, {}), ElementsAre(Triangle{0, 1, 2}, Triangle{1, 3, 2}, Triangle{2, 3, 4}));
  EXPECT_THAT(TrianglesOf(6, {}), ElementsAre(Triangle{1, 2, 0}, Triangle{2, 3, 0}, Triangle{3, 4, 0}));
  EXPECT_THAT(TrianglesOf(6, {4, 3, 2}), ElementsAre(Triangle{3, 2, 4}));
}

TEST(GltfMesh, StripsKeepOneFacing) {
  // A zigzag of unit squares in the plane: every triangle must be counter-clockwise as the first is.
  const auto triangles = TrianglesOf(5, {0, 1, 2, 3});
  for (const Triangle& t : triangles) {
    const auto p = [&](uint32_t v, int axis) { return kFivePoints[3 * v + size_t(axis)]; };
    const float area = (p(t[1], 0) - p(t[0], 0)) * (p(t[2], 1) - p(t[0], 1)) -
                       (p(t[2], 0) - p(t[0], 0)) * (p(t[1], 1) - p(t[0], 1));
    EXPECT_EQ(area, 1.0f);
  }
}

TEST(GltfMesh, CountsPointsAndLinesThatAreNotDrawn) {
  GltfBuilder file;
  const int positions = file.Floats("VEC3", kFivePoints);
  for (const int mode : {0, 1, 2, 3})
    file.Draw(file.Mesh({{"attributes", {{"POSITION", positions}}}, {"mode", mode}}));
  EXPECT_THAT(MustFail(file).message(), HasSubstr("nothing to draw"));
  file.DrawTriangle();
  const auto scene = MustImport(file);
  EXPECT_EQ(scene->report.skipped_points, 5);
  EXPECT_EQ(scene->report.skipped_lines, 2 + 5 + 4);
  EXPECT_EQ(scene->report.stored_triangles, 1);
  EXPECT_TRUE(scene->meshes[0].primitives.empty());
}

template <typename Component>
V3f FirstPosition(int component_type, std::vector<Component> values, bool normalized) {
  GltfBuilder file;
  // Padded to a multiple of four bytes a vertex, as glTF wants it.
  const size_t stride = (3 * sizeof(Component) + 3) / 4 * 4;
  std::string bytes;
  for (int v = 0; v < 3; ++v) {
    std::string element(reinterpret_cast<const char*>(values.data()), 3 * sizeof(Component));
    element.resize(stride, '\x7f');
    bytes += element;
  }
  const int accessor =
      file.AccessorOn(file.View(bytes, int(stride)), 0, "VEC3", component_type, 3, normalized);
  file.Draw(file.Mesh({{"attributes", {{"POSITION", accessor}}}}));
  const auto scene = MustImport(file);
  return scene->meshes[0].primitives[0].positions[2];
}

TEST(GltfMesh, ReadsEveryComponentTypeAndNormalisesIntegers) {
  EXPECT_EQ(FirstPosition<int8_t>(5120, {-128, 0, 127}, false), V3f(-128, 0, 127));
  EXPECT_EQ(FirstPosition<int8_t>(5120, {-128, -127, 127}, true), V3f(-1, -1, 1));
  EXPECT_EQ(FirstPosition<uint8_t>(5121, {0, 51, 255}, true), V3f(0, 0.2f, 1));
  EXPECT_EQ(FirstPosition<int16_t>(5122, {-32768, -32767, 32767}, true), V3f(-1, -1, 1));
  EXPECT_EQ(FirstPosition<uint16_t>(5123, {0, 13107, 65535}, true), V3f(0, 0.2f, 1));
  EXPECT_EQ(FirstPosition<uint16_t>(5123, {0, 13107, 65535}, false), V3f(0, 13107, 65535));
  EXPECT_EQ(FirstPosition<uint32_t>(5125, {0, 1u << 31, 7}, false), V3f(0, 2147483648.0f, 7));
  EXPECT_EQ(FirstPosition<float>(5126, {-0.5f, 1e-30f, 3e38f}, false), V3f(-0.5f, 1e-30f, 3e38f));
}

TEST(GltfMesh, ReadsInterleavedViewsAndEqualBytesStayEqual) {
  GltfBuilder file;
  std::vector<float> rows;
  for (const float x : {0.1f, 0.3f, 0.1f}) {
    for (const float value : {x, x * 3, -x, 0.0f, 0.0f, 1.0f, x, 1 - x}) rows.push_back(value);
  }
  const int view = file.View(std::string(reinterpret_cast<const char*>(rows.data()), rows.size() * 4), 32);
  file.Draw(file.Mesh({{"attributes",
                        {{"POSITION", file.AccessorOn(view, 0, "VEC3", 5126, 3)},
                         {"NORMAL", file.AccessorOn(view, 12, "VEC3", 5126, 3)},
                         {"TEXCOORD_1", file.AccessorOn(view, 24, "VEC2", 5126, 3)}}}}));
  const auto scene = MustImport(file);
  const MeshPrimitive& primitive = scene->meshes[0].primitives[0];
  EXPECT_EQ(primitive.positions[1], V3f(0.3f, 0.3f * 3, -0.3f));
  EXPECT_EQ(primitive.positions[0], primitive.positions[2]);
  EXPECT_EQ(primitive.normals[2], V3f(0, 0, 1));
  EXPECT_TRUE(primitive.texcoords[0].empty());
  EXPECT_EQ(primitive.texcoords[1][1], V2f(0.3f, 1 - 0.3f));
}

TEST(GltfMesh, SparseElementsReplaceThoseBelow) {
  GltfBuilder file;
  // Without a buffer view below, the accessor is zeros.
  const int positions = file.AccessorOn(-1, 0, "VEC3", 5126, 3);
  const std::vector<float> values = {5, 6, 7, 8, 9, 10};
  file.json["accessors"][size_t(positions)]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", file.View(std::string("\0\2", 2))}, {"componentType", 5121}}},
      {"values", {{"bufferView", file.View(std::string(reinterpret_cast<const char*>(values.data()), 24))}}}};
  file.Draw(file.Mesh({{"attributes", {{"POSITION", positions}}}}));
  EXPECT_THAT(MustImport(file)->meshes[0].primitives[0].positions,
              ElementsAre(V3f(5, 6, 7), V3f(0, 0, 0), V3f(8, 9, 10)));
  // Indices out of range, and such as do not increase.
  file.buffer[0] = 3;
  EXPECT_THAT(MustFail(file).message(), HasSubstr("sparse index 0 (3) is not below the count"));
  file.buffer[0] = 2;
  EXPECT_THAT(MustFail(file).message(), HasSubstr("sparse index 1 (2) does not increase"));
}

TEST(GltfMesh, ReadsColoursOfThreeAndFourComponents) {
  GltfBuilder file;
  const int positions = file.Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int rgb = file.Floats("VEC3", {.1f, .2f, .3f, 0, 0, 0, 1, 1, 1});
  const int rgba = file.Accessor<uint8_t>("VEC4", 5121, {0, 51, 255, 102, 0, 0, 0, 0, 0, 0, 0, 0}, true);
  file.Draw(file.Mesh({{"attributes", {{"POSITION", positions}, {"COLOR_0", rgb}}}}));
  file.Draw(file.Mesh({{"attributes", {{"POSITION", positions}, {"COLOR_0", rgba}}}}));
  const auto scene = MustImport(file);
  EXPECT_EQ(scene->meshes[0].primitives[0].colors[0], V4f(.1f, .2f, .3f, 1));
  EXPECT_EQ(scene->meshes[1].primitives[0].colors[0], V4f(0, .2f, 1, .4f));
  // Shared positions, other colours: two drawn, one stored.
  EXPECT_EQ(scene->report.stored_triangles, 1);
}

TEST(GltfMesh, DropsTrianglesOfVerticesThatAreNotFinite) {
  const float inf = std::numeric_limits<float>::infinity();
  GltfBuilder file;
  std::vector<float> points = kFivePoints;
  points[3 * 4 + 1] = inf;
  points[3 * 3] = std::nanf("");
  file.Draw(file.Mesh({{"attributes", {{"POSITION", file.Floats("VEC3", points)}}},
                       {"indices", file.Indices({0, 1, 2, 1, 3, 2, 2, 3, 4, 2, 1, 0})}}));
  const auto scene = MustImport(file);
  const MeshPrimitive& primitive = scene->meshes[0].primitives[0];
  EXPECT_THAT(primitive.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{2, 1, 0}));
  EXPECT_EQ(primitive.positions.size(), 5u);
  EXPECT_EQ(scene->report.dropped_triangles, 2);
  ASSERT_EQ(scene->report.warnings.size(), 1u);
  EXPECT_THAT(scene->report.warnings[0], HasSubstr("mesh 0 primitive 0: 2 vertices, the first of them 3"));
}

TEST(GltfMesh, ReadsMorphTargetsAndTheirDefaultWeights) {
  GltfBuilder file;
  const int positions = file.Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int normals = file.Floats("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int moved = file.Floats("VEC3", {0, 0, 1, 0, 0, 2, 0, 0, 3});
  const int mesh = file.Mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                              {"targets", {{{"POSITION", moved}, {"NORMAL", moved}}, {{"NORMAL", moved}}}}});
  const int node = file.Draw(mesh);
  auto scene = MustImport(file);
  EXPECT_THAT(scene->meshes[0].weights, ElementsAre(0, 0));
  const MeshPrimitive& primitive = scene->meshes[0].primitives[0];
  ASSERT_EQ(primitive.targets.size(), 2u);
  EXPECT_EQ(primitive.targets[0].positions[2], V3f(0, 0, 3));
  EXPECT_EQ(primitive.targets[0].normals[1], V3f(0, 0, 2));
  EXPECT_TRUE(primitive.targets[1].positions.empty());

  file.json["meshes"][0]["weights"] = {0.25, 0.5};
  file.json["nodes"][size_t(node)]["weights"] = {1, 2};
  scene = MustImport(file);
  EXPECT_THAT(scene->meshes[0].weights, ElementsAre(0.25f, 0.5f));
  EXPECT_THAT(scene->nodes[0].weights, ElementsAre(1, 2));
  file.json["nodes"][size_t(node)]["weights"] = {1};
  EXPECT_THAT(MustFail(file).message(), HasSubstr("node 0: weights: 1 of them for 2 morph targets"));
}

TEST(GltfMesh, UsesTheDefaultMaterialWhereAPrimitiveHasNone) {
  GltfBuilder file;
  file.Add("materials", {{"name", "red"}});
  file.DrawTriangle();
  const auto scene = MustImport(file);
  ASSERT_EQ(scene->materials.size(), 2u);
  EXPECT_EQ(scene->meshes[0].primitives[0].material, 1);
  EXPECT_EQ(scene->materials[1].base_color_factor, V4f(1, 1, 1, 1));
}

}  // namespace
}  // namespace shutterline::engine::mesh_test
