#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "tests/engine/scene_motion/scene_builder.h"
#include "worker/engine/scene/tangent_space.h"

// What a frame has for shading: tangents in view space, pyramids.
namespace shutterline::engine::frame_material_test {
namespace {

/// A slope of two triangles with smooth normals, a picture on it and a normal texture.
struct NormalMapped : SceneBuilder {
  int node = -1;

  NormalMapped() {
    MeshPrimitive slope;
    slope.positions = {{0, 0, 0}, {1, 0, -1}, {1, 1, -1}, {0, 1, 0}};
    const auto h = float(std::sqrt(0.5));
    slope.normals.assign(4, V3f(h, 0, h));
    slope.texcoords[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    slope.triangles = {{0, 1, 2}, {0, 2, 3}};
    slope.tangents = MakeTangents(slope, 0);
    scene->materials[0].normal_texture.texture = AddTexture();
    AddCamera();
    node = AddNode(-1, V3d(0), AddMesh(slope));
  }
  int AddTexture() {
    TextureImage image;
    image.width = image.height = 1;
    image.rgba = {128, 128, 255, 255};
    scene->images.push_back(image);
    scene->textures.emplace_back();
    scene->textures.back().image = int(scene->images.size()) - 1;
    return int(scene->textures.size()) - 1;
  }
  MeshPrimitive& slope() { return scene->meshes[0].primitives[0]; }
  NodeTransform& transform() { return scene->nodes[size_t(node)].transform; }
  std::shared_ptr<const FrameScene> Build(const RenderSettings& settings = SquareSettings()) {
    const auto built = BuildFrameScene(scene, 0, settings);
    EXPECT_TRUE(built.ok()) << built.status();
    return built.ok() ? *built : nullptr;
  }
};

V3d Direction(const V4f& tangent) {
  return {double(tangent.x), double(tangent.y), double(tangent.z)};
}

void ExpectAll(const FrameScene& frame, const V3d& direction, float sign) {
  for (const V4f& tangent : frame.tangents) {
    EXPECT_LT((Direction(tangent) - direction).length(), 1e-6) << tangent;
    EXPECT_EQ(tangent.w, sign);
  }
}

TEST(FrameTangents, TurnWithTheNode) {
  NormalMapped s;
  const double h = std::sqrt(0.5);
  auto frame = s.Build();
  EXPECT_TRUE(frame->primitives[0].has_tangents);
  EXPECT_EQ(frame->primitives[0].first_tangent, 0u);
  ASSERT_EQ(frame->tangents.size(), 6u);
  ExpectAll(*frame, V3d(h, 0, -h), 1);
  s.transform().rotation.setAxisAngle(V3d(0, 0, 1), std::acos(0));  // x becomes y.
  ExpectAll(*s.Build(), V3d(0, h, -h), 1);
  s.transform() = NodeTransform();
  s.transform().scale = V3d(3, 1, 4);  // Along the surface: not by the inverse transpose.
  ExpectAll(*s.Build(), V3d(0.6, 0, -0.8), 1);
}

TEST(FrameTangents, AreMirroredWithTheNode) {
  // A node mirrored in x: the tangent's x turns, and so does the sign, which is that of the mirrored picture.
  NormalMapped s;
  s.transform().scale = V3d(-1, 1, 1);
  ASSERT_TRUE(s.Build()->primitives[0].mirrored);
  const double h = std::sqrt(0.5);
  ExpectAll(*s.Build(), V3d(-h, 0, -h), -1);
}

/// The tangents of a frame, held against positions and texture coordinates as they are in view space: the
/// tangent is along growing u and the bitangent along falling v.
void ExpectToFollowTheTexture(const FrameScene& frame, const char* trace) {
  SCOPED_TRACE(trace);
  const FramePrimitive& primitive = frame.primitives[0];
  for (uint32_t t = 0; t < primitive.triangle_count; ++t) {
    const FrameTriangle& triangle = frame.triangles[primitive.first_triangle + t];
    V3d place[3];
    V2d uv[3];
    for (size_t k = 0; k < 3; ++k) {
      place[k] = frame.view.ViewFromRaster(frame.VertexAt(primitive, triangle.vertices[k], 0.5));
      uv[k] = V2d(primitive.source->texcoords[0][triangle.vertices[k] - primitive.first_vertex]);
    }
    const V3d e1 = place[1] - place[0], e2 = place[2] - place[0];
    const V2d d1 = uv[1] - uv[0], d2 = uv[2] - uv[0];
    const double area = d1.x * d2.y - d1.y * d2.x;
    const V3d along_u = (d2.y * e1 - d1.y * e2) / area, along_v = (d1.x * e2 - d2.x * e1) / area;
    for (size_t k = 0; k < 3; ++k) {
      const V4f& tangent = frame.tangents[primitive.first_tangent + 3 * t + k];
      const V3d normal(frame.normals[primitive.first_normal + triangle.vertices[k] - primitive.first_vertex]);
      EXPECT_LT((Direction(tangent) - along_u.normalized()).length(), 1e-5);
      EXPECT_LT(double(tangent.w) * normal.cross(Direction(tangent)).dot(along_v), 0);
    }
  }
}

TEST(FrameTangents, FollowTheTextureUnderAnyTransform) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-2, 2);
  for (int trial = 0; trial < 50; ++trial) {
    NormalMapped s;
    s.transform().scale = V3d(uniform(random), uniform(random), uniform(random));
    Quatd& rotation = s.transform().rotation;
    rotation = Quatd(uniform(random), uniform(random), uniform(random), uniform(random));
    rotation.normalize();
    if (trial % 2 == 1) {  // The picture mirrored on the surface.
      for (V2f& uv : s.slope().texcoords[0]) uv.x = 1 - uv.x;
      s.slope().tangents = MakeTangents(s.slope(), 0);
    }
    ExpectToFollowTheTexture(*s.Build(), ("trial " + std::to_string(trial)).c_str());
  }
}

TEST(FrameTangents, AreThoseOfMidShutter) {
  NormalMapped s;
  const auto h = float(std::sqrt(0.5));
  s.AddChannel(s.node, AnimatedPath::kRotation, {0, 1}, {0, 0, 0, 1, 0, 0, h, h});
  // A quarter turn about z: half-way, (1, 0, -1) is (h, h, -1).
  ExpectAll(*s.Build(), V3d(0.5, 0.5, -std::sqrt(0.5)), 1);
}

TEST(FrameTangents, FollowTheJoints) {
  NormalMapped s;
  const int still = s.AddNode(), bent = s.AddNode();
  s.scene->nodes[size_t(bent)].transform.rotation.setAxisAngle(V3d(0, 0, 1), std::acos(0));
  s.scene->skins.push_back({"bones", {still, bent}, {M44d(), M44d()}});
  s.scene->nodes[size_t(s.node)].skin = 0;
  s.slope().influences.resize(4);
  for (size_t v = 0; v < 4; ++v) {
    s.slope().influences[v].joints[1] = 1;
    s.slope().influences[v].weights[v < 2 ? 0 : 1] = 1;
  }
  const auto frame = s.Build();
  const double h = std::sqrt(0.5);
  const V3d at_still(h, 0, -h), at_bent(0, h, -h);
  // Corners 0, 1, 2 and 0, 2, 3.
  for (const size_t i : {0, 1, 3}) EXPECT_LT((Direction(frame->tangents[i]) - at_still).length(), 1e-6);
  for (const size_t i : {2, 4, 5}) EXPECT_LT((Direction(frame->tangents[i]) - at_bent).length(), 1e-6);
}

TEST(FrameTangents, AreByTheCornersOfTheTrianglesThatAreDrawn) {
  for (const bool mirrored : {false, true}) {
    NormalMapped s;
    MeshPrimitive& slope = s.slope();
    slope.positions.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.f, 0.f);
    slope.normals.emplace_back(0.f, 0.f, 1.f);
    slope.texcoords[0].emplace_back(0.f, 0.f);
    slope.triangles = {{0, 1, 4}, {0, 1, 2}, {4, 2, 3}, {0, 2, 3}};
    slope.tangents.clear();
    // A direction of its own for each corner: the whole numbers from 0.
    for (int i = 0; i < 12; ++i) slope.tangents.emplace_back(1.f, float(i), 0.f, 1.f);
    if (mirrored) s.transform().scale = V3d(1, 1, -1);
    // Another primitive behind it, to see where that begins.
    s.scene->meshes[0].primitives.push_back(slope);
    const auto frame = s.Build();
    ASSERT_EQ(frame->tangents.size(), 12u);
    EXPECT_EQ(frame->primitives[1].first_tangent, 6u);
    const std::array<int, 6> expected =
        mirrored ? std::array{3, 5, 4, 9, 11, 10} : std::array{3, 4, 5, 9, 10, 11};
    for (size_t i = 0; i < 12; ++i) {
      const V4f& tangent = frame->tangents[i];
      EXPECT_NEAR(tangent.y / tangent.x, expected[i % 6], 1e-4);
    }
  }
}

TEST(FrameTangents, AreOnlyWhereANormalTextureShows) {
  const auto has_tangents = [](const auto& change) {
    NormalMapped s;
    change(s);
    const auto frame = s.Build();
    EXPECT_EQ(frame->primitives[0].has_tangents, !frame->tangents.empty());
    return frame->primitives[0].has_tangents;
  };
  EXPECT_TRUE(has_tangents([](NormalMapped&) {}));
  EXPECT_TRUE(has_tangents([](NormalMapped& s) { s.slope().normals.clear(); }));  // Those of the triangles.
  EXPECT_FALSE(has_tangents([](NormalMapped& s) { s.scene->materials[0].unlit = true; }));
  EXPECT_FALSE(has_tangents([](NormalMapped& s) { s.scene->materials[0].normal_texture.texture = -1; }));
  EXPECT_FALSE(has_tangents([](NormalMapped& s) { s.slope().texcoords[0].clear(); }));
  EXPECT_FALSE(has_tangents([](NormalMapped& s) { s.slope().tangents.clear(); }));
}

TEST(FramePyramids, AreMadeForWhatIsDrawnInItsEncoding) {
  NormalMapped s;
  s.scene->materials.emplace_back();  // Of no mesh.
  Material& material = s.scene->materials[0];
  material.base_color_texture.texture = s.AddTexture();
  material.emissive_texture.texture = s.AddTexture();
  material.metallic_roughness_texture.texture = s.AddTexture();
  material.occlusion_texture.texture = s.AddTexture();
  material.specular_texture.texture = s.AddTexture();
  material.specular_color_texture.texture = s.AddTexture();
  s.scene->materials[1].base_color_texture.texture = s.AddTexture();

  auto frame = s.Build();
  const auto encodings = [&](const TextureRef& reference) {
    const int image = s.scene->textures[size_t(reference.texture)].image;
    return std::pair(frame->Pyramid(image, TextureEncoding::kSrgb) != nullptr,
                     frame->Pyramid(image, TextureEncoding::kLinear) != nullptr);
  };
  const std::pair srgb(true, false), linear(false, true), none(false, false);
  EXPECT_EQ(encodings(material.base_color_texture), srgb);
  EXPECT_EQ(encodings(material.emissive_texture), srgb);
  EXPECT_EQ(encodings(material.specular_color_texture), srgb);
  EXPECT_EQ(encodings(material.metallic_roughness_texture), linear);
  EXPECT_EQ(encodings(material.normal_texture), linear);
  EXPECT_EQ(encodings(material.occlusion_texture), linear);
  EXPECT_EQ(encodings(material.specular_texture), linear);
  EXPECT_EQ(encodings(s.scene->materials[1].base_color_texture), none);
  EXPECT_EQ(frame->Pyramid(-1, TextureEncoding::kSrgb), nullptr);
  EXPECT_EQ(frame->Pyramid(99, TextureEncoding::kSrgb), nullptr);
  // Frames share them.
  EXPECT_EQ(s.Build()->Pyramid(0, TextureEncoding::kLinear), frame->Pyramid(0, TextureEncoding::kLinear));

  material.unlit = true;
  frame = s.Build();
  EXPECT_EQ(encodings(material.base_color_texture), srgb);
  EXPECT_EQ(encodings(material.normal_texture), none);
  EXPECT_EQ(encodings(material.emissive_texture), none);
}

}  // namespace
}  // namespace shutterline::engine::frame_material_test
