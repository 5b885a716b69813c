#include "worker/engine/shading/shade.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/engine/scene_motion/scene_builder.h"

namespace shutterline::engine {
namespace {

/// A quad from (-1, -1, 0) to (1, 1, 0) before a camera at (0, 0, 5); its texture coordinates run from
/// (0, 0) at the top left to (1, 1).
struct QuadScene : SceneBuilder {
  int node = -1;

  QuadScene() {
    MeshPrimitive quad;
    quad.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    quad.triangles = {{0, 1, 2}, {0, 2, 3}};
    quad.texcoords[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    AddCamera();
    node = AddNode(-1, V3d(0), AddMesh(quad));
  }
  MeshPrimitive& quad() { return scene->meshes[0].primitives[0]; }
  Material& material() { return scene->materials[0]; }

  int AddTexture(int width, int height, const std::vector<uint8_t>& rgba) {
    TextureImage image;
    image.width = width;
    image.height = height;
    image.rgba = rgba;
    scene->images.push_back(image);
    scene->textures.emplace_back();
    scene->textures.back().image = int(scene->images.size()) - 1;
    return int(scene->textures.size()) - 1;
  }
  std::shared_ptr<const FrameScene> Build(const RenderSettings& settings = SquareSettings()) {
    const auto built = BuildFrameScene(scene, 0, settings);
    EXPECT_TRUE(built.ok()) << built.status().ToString();
    return *built;
  }
};

Shader HeadLit(std::shared_ptr<const FrameScene> frame) {
  RenderSettings settings;
  settings.lighting = LightingKind::kHeadlight;
  return *Shader::Create(std::move(frame), settings);
}

void ExpectColor(const V3f& actual, const V3d& expected, double tolerance = 1e-6) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(actual.z, expected.z, tolerance);
}

TEST(Shade, UnlitIsTheBaseColourAndNothingElse) {
  QuadScene s;
  s.material().unlit = true;
  s.material().base_color_factor = {0.25f, 0.5f, 2, 0.1f};
  s.material().emissive_factor = {9, 9, 9};
  s.quad().normals.assign(4, V3f(1, 0, 0));
  const auto frame = s.Build();
  EXPECT_FALSE(frame->primitives[0].has_normals);
  EXPECT_TRUE(HeadLit(frame).IsConstant(frame->primitives[0]));
  EXPECT_EQ(HeadLit(frame).Shade(0, {0.2, 0.3}, {}), V3f(0.25f, 0.5f, 2));
}

TEST(Shade, HeadLightFallsOffWithTheCosine) {
  for (const double angle : {0.0, 0.4, 1.2}) {
    QuadScene s;
    s.material().base_color_factor = {1, 0.5f, 0.25f, 1};
    // Seen from far away, the direction to the camera is the same all over.
    s.scene->nodes[0].transform.translation = {0, 0, 1e9};
    s.scene->nodes[size_t(s.node)].transform.rotation.setAxisAngle(V3d(0, 1, 0), angle);
    const double light = 0.15 + 0.85 * std::cos(angle);
    ExpectColor(HeadLit(s.Build()).Shade(0, {0.2, 0.3}, {}), light * V3d(1, 0.5, 0.25));
    // The same by vertex normals, the wrong way round even.
    s.quad().normals.assign(4, V3f(0, 0, -1));
    ExpectColor(HeadLit(s.Build()).Shade(0, {0.2, 0.3}, {}), light * V3d(1, 0.5, 0.25));
  }
}

TEST(Shade, TheDirectionToTheCameraIsThatOfThePoint) {
  QuadScene s;
  const auto frame = s.Build();
  EXPECT_FALSE(HeadLit(frame).IsConstant(frame->primitives[0]));
  // Triangle 0 has its corners at (-1, -1), (1, -1) and (1, 1); the camera is 5 m away.
  for (const auto& [b1, b2] : {std::pair(0.0, 0.0), std::pair(0.5, 0.25), std::pair(0.0, 1.0)}) {
    const double x = -1 + 2 * b1 + 2 * b2, y = -1 + 2 * b2;
    const double cosine = 5 / std::sqrt(x * x + y * y + 25);
    ExpectColor(HeadLit(frame).Shade(0, {b1, b2}, {}), V3d(0.15 + 0.85 * cosine));
  }
}

TEST(Shade, OrthographicViewsHaveOneDirection) {
  QuadScene s;
  s.scene->cameras[0].perspective = false;
  s.scene->cameras[0].zfar = 100;
  ExpectColor(HeadLit(s.Build()).Shade(0, {0.9, 0.05}, {}), V3d(1));
}

TEST(Shade, NormalsAreInterpolated) {
  QuadScene s;
  s.scene->nodes[0].transform.translation = {0, 0, 1e9};
  const float h = std::sqrt(0.5f);
  s.quad().normals = {V3f(h, 0, h), V3f(-h, 0, h), V3f(-h, 0, h), V3f(h, 0, h)};
  const auto frame = s.Build();
  ExpectColor(HeadLit(frame).Shade(0, {0, 0}, {}), V3d(0.15 + 0.85 * std::sqrt(0.5)));
  ExpectColor(HeadLit(frame).Shade(0, {0.5, 0}, {}), V3d(1));
}

TEST(Shade, EmissionIsAddedToTheLight) {
  QuadScene s;
  s.material().base_color_factor = {0, 0, 0, 1};
  s.material().emissive_factor = {1, 0.5f, 3};
  ExpectColor(HeadLit(s.Build()).Shade(0, {0.2, 0.3}, {}), V3d(1, 0.5, 3));
  s.material().emissive_texture.texture = s.AddTexture(1, 1, {255, 255, 0, 255});
  ExpectColor(HeadLit(s.Build()).Shade(0, {0.2, 0.3}, {}), V3d(1, 0.5, 0));
}

TEST(Shade, VertexColoursAreMultipliedIn) {
  QuadScene s;
  s.material().unlit = true;
  s.material().base_color_factor = {0.5f, 1, 1, 1};
  s.quad().colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {0, 0, 0, 1}};
  auto frame = s.Build();
  EXPECT_FALSE(HeadLit(frame).IsConstant(frame->primitives[0]));
  ExpectColor(HeadLit(frame).Shade(0, {0.25, 0.5}, {}), V3d(0.125, 0.25, 0.5));
  s.quad().colors.assign(4, V4f(0.5f, 0.25f, 1, 1));
  frame = s.Build();
  EXPECT_TRUE(HeadLit(frame).IsConstant(frame->primitives[0]));
  ExpectColor(HeadLit(frame).Shade(0, {0.25, 0.5}, {}), V3d(0.25, 0.25, 1));
}

TEST(Shade, TexturesLieTheRightWayUp) {
  QuadScene s;
  s.material().unlit = true;
  // Red, green above blue, white; nearest, so that a quarter of the quad has one colour.
  s.material().base_color_texture.texture =
      s.AddTexture(2, 2, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255});
  s.scene->textures[0].nearest = true;
  const auto frame = s.Build();
  EXPECT_FALSE(HeadLit(frame).IsConstant(frame->primitives[0]));
  ExpectColor(HeadLit(frame).Shade(0, {0.1, 0.1}, {}), V3d(0, 0, 1));   // Near (-1, -1): bottom left.
  ExpectColor(HeadLit(frame).Shade(0, {0.8, 0.1}, {}), V3d(1, 1, 1));   // Near (1, -1): bottom right.
  ExpectColor(HeadLit(frame).Shade(0, {0.1, 0.8}, {}), V3d(0, 1, 0));   // Near (1, 1): top right.
  ExpectColor(HeadLit(frame).Shade(1, {0.1, 0.85}, {}), V3d(1, 0, 0));  // Near (-1, 1): top left.
  // A pixel larger than the quad sees the mean of all.
  ExpectColor(HeadLit(frame).Shade(0, {0.1, 0.1}, {.db1_dx = 2, .db1_dy = 0, .db2_dx = 0, .db2_dy = 2}),
              V3d(0.5), 1e-4);
}

TEST(Shade, MaterialsWhoseMeshHasNoCoordinatesIgnoreTheTexture) {
  QuadScene s;
  s.material().unlit = true;
  s.material().base_color_texture.texture = s.AddTexture(1, 1, {0, 0, 0, 255});
  s.material().base_color_texture.texcoord = 1;
  const auto frame = s.Build();
  EXPECT_TRUE(HeadLit(frame).IsConstant(frame->primitives[0]));
  EXPECT_EQ(HeadLit(frame).Shade(0, {0.1, 0.1}, {}), V3f(1));
}

TEST(Shade, FramesOfASceneShareTheirTextures) {
  QuadScene s;
  s.material().base_color_texture.texture = s.AddTexture(1, 1, {1, 2, 3, 255});
  s.AddTexture(1, 1, {4, 5, 6, 255});
  const auto one = s.Build(), two = s.Build();
  EXPECT_NE(one->Pyramid(0, TextureEncoding::kSrgb), nullptr);
  EXPECT_EQ(one->Pyramid(0, TextureEncoding::kSrgb), two->Pyramid(0, TextureEncoding::kSrgb));
  EXPECT_EQ(one->Pyramid(0, TextureEncoding::kLinear), nullptr);
  EXPECT_EQ(one->Pyramid(1, TextureEncoding::kSrgb), nullptr);  // No material uses it.
}

TEST(Shade, MirroredNodesLookLikeTheirMirrorImage) {
  QuadScene plain, mirrored;
  for (QuadScene* s : {&plain, &mirrored}) {
    s->material().unlit = true;
    s->quad().colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {1, 1, 0, 1}};
  }
  mirrored.scene->nodes[size_t(mirrored.node)].transform.scale = {-1, 1, 1};
  const auto a = plain.Build(), b = mirrored.Build();
  ASSERT_TRUE(b->primitives[0].mirrored);
  // Corners 1 and 2 are swapped in the mirrored triangle, and so are their barycentric coordinates.
  EXPECT_EQ(HeadLit(a).Shade(0, {0.125, 0.5}, {}), HeadLit(b).Shade(0, {0.5, 0.125}, {}));
}

Shader Lit(std::shared_ptr<const FrameScene> frame, LightingKind kind, double ambient = 0) {
  RenderSettings settings;
  settings.lighting = kind;
  settings.ambient = {ambient, ambient, ambient};
  return *Shader::Create(std::move(frame), settings);
}

/// A sun on the quad, from `angle` to its normal, turned about y.
int AddSun(QuadScene& s, double angle) {
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::kDirectional;
  sun.intensity = float(M_PI);
  s.scene->lights.push_back(sun);
  const int node = s.AddNode(-1, V3d(0), -1);
  s.scene->nodes[size_t(node)].transform.rotation.setAxisAngle(V3d(0, 1, 0), angle);
  s.scene->nodes[size_t(node)].light = int(s.scene->lights.size()) - 1;
  return node;
}

Material Matte() {
  Material matte;
  matte.metallic_factor = 0;
  matte.specular_factor = 0;
  return matte;
}

TEST(Shade, ScenesWithoutLightsStandInTheStudioOthersInTheirOwn) {
  QuadScene s;
  s.material() = Matte();
  const V3f studio = Lit(s.Build(), LightingKind::kAuto).Shade(0, {0.2, 0.3}, {});
  EXPECT_EQ(studio, Lit(s.Build(), LightingKind::kStudio).Shade(0, {0.2, 0.3}, {}));
  EXPECT_EQ(Lit(s.Build(), LightingKind::kScene).Shade(0, {0.2, 0.3}, {}), V3f(0));
  AddSun(s, 0.5);
  const V3f sun = Lit(s.Build(), LightingKind::kAuto).Shade(0, {0.2, 0.3}, {});
  ExpectColor(sun, V3d(std::cos(0.5)));  // π lux make a white surface that faces them 1.
  EXPECT_EQ(Lit(s.Build(), LightingKind::kStudio).Shade(0, {0.2, 0.3}, {}), studio);
  ExpectColor(Lit(s.Build(), LightingKind::kScene, 0.25).Shade(0, {0.2, 0.3}, {}), V3d(std::cos(0.5) + 0.25));
}

TEST(Shade, AnEnvironmentLightsTheScene) {
  QuadScene s;
  s.material() = Matte();
  auto picture = std::make_shared<Environment>();
  picture->width = 64;
  picture->height = 32;
  picture->texels.assign(64 * 32, V3f(0.25f, 0.5f, 1));
  s.scene->environment = picture;
  for (const LightingKind kind : {LightingKind::kAuto, LightingKind::kScene}) {
    ExpectColor(Lit(s.Build(), kind).Shade(0, {0.2, 0.3}, {}), V3d(0.25, 0.5, 1), 1e-3);
  }
  AddSun(s, 0.5);
  ExpectColor(Lit(s.Build(), LightingKind::kAuto).Shade(0, {0.2, 0.3}, {}),
              V3d(0.25, 0.5, 1) + V3d(std::cos(0.5)), 1e-3);
}

TEST(Shade, WhatStandsInTheLightCastsAShadow) {
  // A small quad hangs before the big one, in the sun of either kind.
  for (const bool glass : {false, true}) {
    for (const auto kind : {PunctualLight::Kind::kDirectional, PunctualLight::Kind::kPoint}) {
      QuadScene s;
      s.material() = Matte();
      s.material().double_sided = true;
      s.scene->nodes[0].transform.translation = {3, 0, 5};  // The camera sees past the small one.
      MeshPrimitive small;
      small.positions = {{-0.2f, -0.2f, 0}, {0.2f, -0.2f, 0}, {0.2f, 0.2f, 0}, {-0.2f, 0.2f, 0}};
      small.triangles = {{0, 2, 1}, {0, 3, 2}};  // It shows its back to the light: that makes no difference.
      small.material = 1;
      s.scene->materials.push_back(Matte());
      if (glass) s.scene->materials[1].alpha_mode = AlphaMode::kBlend;
      s.AddNode(-1, V3d(0, 0, 1), s.AddMesh(small));
      const int light = AddSun(s, 0);
      s.scene->lights.back().kind = kind;
      s.scene->nodes[size_t(light)].transform.translation = {0, 0, 3};
      const Shader shader = Lit(s.Build(), LightingKind::kScene);
      // (0.05, 0.02) lies behind the small quad, (0.9, -0.7) beside its shadow.
      const auto at = [&](double x, double y) {
        return shader.Shade(0, {(x + 1) / 2 - (y + 1) / 2, (y + 1) / 2}, {}).x;
      };
      EXPECT_GT(at(0.9, -0.7), 0.05);
      EXPECT_EQ(at(0.05, 0.02) == 0, !glass);
    }
  }
}

TEST(Shade, SurfacesDoNotShadowThemselves) {
  for (uint32_t seed = 1; seed <= 64; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform;
    QuadScene s;
    s.material() = Matte();
    s.scene->nodes[size_t(s.node)].transform.rotation.setAxisAngle(
        V3d(uniform(random), uniform(random), uniform(random)).normalized(), uniform(random));
    s.scene->nodes[size_t(s.node)].transform.translation = {0, 0, -1000 * uniform(random)};
    AddSun(s, 1.2 * uniform(random));
    const auto frame = s.Build();
    const Shader shader = Lit(frame, LightingKind::kScene);
    Lighting without = *MakeLighting(*frame, [] {
      RenderSettings settings;
      settings.lighting = LightingKind::kScene;
      return settings;
    }());
    without.shadows = nullptr;
    const Shader bare(frame, without);
    for (int i = 0; i < 20; ++i) {
      const double b1 = uniform(random), b2 = (1 - b1) * uniform(random);
      EXPECT_EQ(shader.Shade(0, {b1, b2}, {}), bare.Shade(0, {b1, b2}, {})) << "seed " << seed;
    }
  }
}

TEST(Shade, OcclusionDarkensTheSkyAlone) {
  QuadScene s;
  s.material() = Matte();
  s.material().occlusion_texture.texture = s.AddTexture(1, 1, {51, 255, 255, 255});  // 0.2 in red.
  s.material().occlusion_strength = 0.5f;
  AddSun(s, 0);
  ExpectColor(Lit(s.Build(), LightingKind::kScene, 1).Shade(0, {0.2, 0.3}, {}), V3d(1 + 0.6));
}

TEST(Shade, MetalAndRoughnessComeFromBlueAndGreen) {
  for (const bool metal : {false, true}) {
    QuadScene textured, plain;
    for (QuadScene* s : {&textured, &plain}) s->material().base_color_factor = {1, 0.5f, 0.25f, 1};
    textured.material().metallic_roughness_texture.texture =
        textured.AddTexture(1, 1, {255, 102, uint8_t(metal ? 255 : 0), 255});
    plain.material().roughness_factor = 0.4f;
    plain.material().metallic_factor = metal ? 1 : 0;
    ExpectColor(Lit(textured.Build(), LightingKind::kStudio).Shade(0, {0.2, 0.3}, {}),
                V3d(Lit(plain.Build(), LightingKind::kStudio).Shade(0, {0.2, 0.3}, {})));
  }
}

TEST(Shade, AnIndexOfOneReflectsNothingAndOfZeroEverything) {
  QuadScene s;
  s.material().metallic_factor = 0;
  s.material().base_color_factor = {0, 0, 0, 1};
  s.material().ior = 1;
  s.material().specular_factor = 0;
  ExpectColor(Lit(s.Build(), LightingKind::kScene, 1).Shade(0, {0.2, 0.3}, {}), V3d(0));
  s.material().ior = 0;
  s.material().specular_factor = 1;
  ExpectColor(Lit(s.Build(), LightingKind::kScene, 1).Shade(0, {0.2, 0.3}, {}), V3d(1));
}

/// A texture that bends the normal by an angle towards +u looks as a quad turned by that angle.
TEST(Shade, NormalTexturesTurnTheNormal) {
  for (const int blue_to_u : {1, -1}) {
    QuadScene s;
    s.material() = Matte();
    s.scene->nodes[0].transform.translation = {0, 0, 1e6};
    s.quad().normals.assign(4, V3f(0, 0, 1));
    s.quad().tangents.assign(6, V4f(float(blue_to_u), 0, 0, 1));
    // (0.6, 0, 0.8) as (204, 127.5, 229.5): the nearest codes.
    s.material().normal_texture.texture = s.AddTexture(1, 1, {204, 128, 230, 255});
    const V3d bent = V3d(2 * 204 / 255.0 - 1, 2 * 128 / 255.0 - 1, 2 * 230 / 255.0 - 1).normalized();
    AddSun(s, 0.9);  // It comes from +x.
    const double cosine = blue_to_u * bent.x * std::sin(0.9) + bent.z * std::cos(0.9);
    ExpectColor(Lit(s.Build(), LightingKind::kScene).Shade(0, {0.2, 0.3}, {}), V3d(std::max(cosine, 0.0)),
                1e-5);
  }
}

TEST(Shade, NormalTexturesTurnWithTheirNode) {
  QuadScene s;
  s.material() = Matte();
  s.quad().normals.assign(4, V3f(0, 0, 1));
  s.quad().tangents.assign(6, V4f(1, 0, 0, 1));
  s.material().normal_texture.texture = s.AddTexture(1, 1, {204, 128, 230, 255});
  s.scene->nodes[0].transform.translation = {0, 0, 1e6};
  // A quarter turn about z: u points up now, and a sun from above is what it leans to.
  s.scene->nodes[size_t(s.node)].transform.rotation.setAxisAngle(V3d(0, 0, 1), M_PI / 2);
  const int sun = AddSun(s, 0);
  s.scene->nodes[size_t(sun)].transform.rotation.setAxisAngle(V3d(1, 0, 0), -0.9);
  const V3d bent = V3d(2 * 204 / 255.0 - 1, 2 * 128 / 255.0 - 1, 2 * 230 / 255.0 - 1).normalized();
  ExpectColor(Lit(s.Build(), LightingKind::kScene).Shade(0, {0.2, 0.3}, {}),
              V3d(bent.x * std::sin(0.9) + bent.z * std::cos(0.9)), 1e-5);
}

TEST(Shade, TextureTransformsScaleThenTurnThenMove) {
  QuadScene s;
  s.material().unlit = true;
  // A picture of 4 × 4 texels, each of its own red.
  std::vector<uint8_t> rgba;
  for (int i = 0; i < 16; ++i) {
    for (const int c : {16 * i, 0, 0, 255}) rgba.push_back(uint8_t(c));
  }
  s.material().base_color_texture.texture = s.AddTexture(4, 4, rgba);
  s.scene->textures[0].nearest = true;
  const auto red = [&](double u, double v) {
    // Triangle 0 has its corners at (u, v) = (0, 1), (1, 1) and (1, 0).
    return HeadLit(s.Build()).Shade(0, {u + v - 1, 1 - v}, {}).x;
  };
  const auto texel = [&](int x, int y) { return LinearFromSrgb8(uint8_t(16 * (x + 4 * y))); };
  EXPECT_EQ(red(0.9, 0.7), texel(3, 2));
  s.material().base_color_texture.transform.scale = {0.5, 0.5};
  EXPECT_EQ(red(0.9, 0.7), texel(1, 1));
  s.material().base_color_texture.transform.offset = {0.5, 0.25};
  EXPECT_EQ(red(0.9, 0.7), texel(3, 2));
  // A quarter turn takes (0.45, 0.35) to (0.35, -0.45): +u goes up, which is -v.
  s.material().base_color_texture.transform.rotation = M_PI / 2;
  s.material().base_color_texture.transform.offset = {0, 1};
  EXPECT_EQ(red(0.9, 0.7), texel(1, 2));
}

TEST(Shade, DegenerateTrianglesShadeToNumbers) {
  QuadScene s;
  s.quad().positions.assign(4, V3f(0, 0, 5));  // A point, in the camera itself.
  const V3f color = HeadLit(s.Build()).Shade(0, {0.25, 0.25}, {});
  EXPECT_EQ(color, V3f(1));
}

}  // namespace
}  // namespace shutterline::engine
