// Shading many points at a time gives the bits of shading one at a time, on every instruction set.
#include "worker/engine/shading/batch_shader.h"

#include <gtest/gtest.h>

#include <array>
#include <iterator>
#include <limits>
#include <random>

#include "tests/engine/scene_motion/scene_builder.h"
#include "tests/support/only_target.h"

namespace shutterline::engine::batch_shader_test {
namespace {

constexpr int kTriangles = 24;
constexpr int kPoints = 600;

class RandomScene : public SceneBuilder {
 public:
  explicit RandomScene(uint64_t seed) : random_(seed) {
    for (int i = 0; i < 5; ++i) AddImage();
    scene->materials[0] = SomeMaterial();
    MeshPrimitive primitive;
    const bool has_normals = Chance(0.7), has_colors = Chance(0.3);
    for (int i = 0; i < 3 * kTriangles; ++i) {
      primitive.positions.push_back(V3f(Number(-3, 3), Number(-3, 3), Number(-3, 3)));
      if (has_normals) primitive.normals.push_back(V3f(Number(-1, 1), Number(-1, 1), Number(-1, 1)));
      if (has_colors) primitive.colors.push_back(V4f(Number(0, 1), Number(0, 1), Number(0, 1), 1));
      // From far beyond a picture's size to a small part of it.
      const float span = i % 3 == 0 ? 40.f : 0.3f;
      primitive.texcoords[0].push_back(V2f(Number(-span, span), Number(-span, span)));
      primitive.texcoords[1].push_back(V2f(Number(-1, 1), Number(-1, 1)));
    }
    // Places where directions vanish, and ones that are huge.
    primitive.positions[0] = primitive.positions[1];
    primitive.positions[3] = V3f(0, 0, 5);
    primitive.positions[6] = V3f(1e30f, 0, 0);
    // Footprints of more images than can be told apart, and beyond all numbers.
    const float odd[] = {3e8f, 1e12f, -1e30f, 3e38f, std::numeric_limits<float>::infinity()};
    for (size_t i = 0; i < std::size(odd); ++i) {
      primitive.texcoords[0][12 + 2 * i].x = odd[i];
      primitive.texcoords[0][13 + 2 * i].y = -odd[i];
    }
    if (has_normals) primitive.normals[9] = primitive.normals[10] = primitive.normals[11] = V3f(0);
    if (scene->materials[0].normal_texture.texture >= 0) {
      for (int i = 0; i < 3 * kTriangles; ++i) {
        primitive.tangents.push_back(
            V4f(Number(-1, 1), Number(-1, 1), Number(-1, 1), Chance(0.5) ? 1.f : -1.f));
      }
    }
    for (uint32_t i = 0; i < kTriangles; ++i) primitive.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    AddCamera();
    scene->cameras[0].zfar = 100;
    if (Chance(0.2)) scene->cameras[0].perspective = false;
    AddNode(-1, V3d(0), AddMesh(primitive));
  }

  float Number(double from, double to) {
    return float(std::uniform_real_distribution<double>(from, to)(random_));
  }
  bool Chance(double of_one) { return Number(0, 1) < of_one; }
  int Below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }

 private:
  void AddImage() {
    TextureImage image;
    image.width = 1 + Below(70);
    image.height = 1 + Below(70);
    if (Chance(0.5)) image.width = image.height = 64;
    const auto texels = size_t(image.width) * size_t(image.height) * 4;
    if (Chance(0.3)) {
      image.rgba16.resize(texels);
      for (uint16_t& code : image.rgba16) code = uint16_t(Below(65536));
    } else {
      image.rgba.resize(texels);
      for (uint8_t& code : image.rgba) code = uint8_t(Below(256));
    }
    scene->images.push_back(image);
    Texture texture;
    texture.image = int(scene->images.size()) - 1;
    texture.wrap_s = WrapMode(Below(3));
    texture.wrap_t = WrapMode(Below(3));
    texture.nearest = Chance(0.2);
    scene->textures.push_back(texture);
  }

  TextureRef SomeTexture() {
    TextureRef reference;
    if (Chance(0.4)) return reference;
    reference.texture = Below(int(scene->textures.size()));
    reference.texcoord = Below(2);
    if (Chance(0.3)) reference.transform = {.offset = {0.1, 0.7}, .rotation = 1.1, .scale = {2, 0.5}};
    // Small footprints, seen at all levels, many images away, and further than is told apart.
    if (Chance(0.3)) reference.transform.offset = {Number(-2e5, 2e5), Number(-2e5, 2e5)};
    if (Chance(0.1)) reference.transform.offset = {3e8 + 0.3, -7e8 - 0.4};
    if (Chance(0.1)) reference.transform.offset = {1e12, -1e30};
    return reference;
  }

  Material SomeMaterial() {
    Material m;
    m.base_color_factor = {Number(0, 1), Number(0, 1), Number(0, 1), 1};
    m.metallic_factor = Number(0, 1);
    m.roughness_factor = Chance(0.2) ? 0.f : Number(0, 1);
    m.normal_scale = Number(0, 2);
    m.occlusion_strength = Number(0, 1);
    if (Chance(0.5)) m.emissive_factor = {Number(0, 2), 0, Number(0, 2)};
    m.ior = Chance(0.2) ? 0.f : Number(1, 2);
    m.specular_factor = Number(0, 1);
    m.specular_color_factor = {Number(0, 1), Number(0, 1), Number(0, 1)};
    m.base_color_texture = SomeTexture();
    m.metallic_roughness_texture = SomeTexture();
    m.normal_texture = SomeTexture();
    m.occlusion_texture = SomeTexture();
    m.emissive_texture = SomeTexture();
    m.specular_texture = SomeTexture();
    m.specular_color_texture = SomeTexture();
    return m;
  }

  std::mt19937_64 random_;
};

std::shared_ptr<const Environment> RandomEnvironment(RandomScene& random) {
  auto environment = std::make_shared<Environment>();
  environment->width = 32;
  environment->height = 16;
  for (int i = 0; i < 32 * 16 + 1; ++i) {
    environment->texels.push_back(V3f(random.Number(0, 4), random.Number(0, 1), random.Number(0, 9)));
  }
  environment->texels.pop_back();
  return environment;
}

TEST(BatchShader, GivesTheBitsOfSinglePoints) {
  int odd = 0, points_seen = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    RandomScene random(seed);
    RenderSettings settings = SquareSettings();
    settings.lighting = seed % 3 == 0 ? LightingKind::kScene : LightingKind::kStudio;
    if (seed % 3 == 0) random.scene->environment = RandomEnvironment(random);
    if (seed % 5 == 0) settings.ambient = {0.1, 0.2, 0.3};
    if (seed % 6 == 0) random.scene->environment = nullptr;  // Ambient light at most.
    const auto frame = BuildFrameScene(random.scene, 0, settings);
    ASSERT_TRUE(frame.ok()) << frame.status();
    if ((*frame)->primitives.empty()) continue;
    const auto shader = Shader::Create(*frame, settings);
    ASSERT_TRUE(shader.ok()) << shader.status();
    const TexelShader texels(*shader, settings, nullptr);
    const BatchShader batches(*shader, texels);
    const FramePrimitive& primitive = (*frame)->primitives[0];
    ASSERT_EQ(batches.Takes(0), shader->IsLitBySkyAlone(primitive));
    if (!batches.Takes(0)) continue;

    std::vector<BatchShader::Point> points;
    std::vector<V3f> expected;
    RenderStats stats;
    for (int i = 0; i < kPoints; ++i) {
      double b1 = random.Number(0, 1), b2 = random.Number(0, 1) * (1 - b1);
      if (i % 50 == 0) b1 = b2 = 0;
      const auto triangle = uint32_t(random.Below(int((*frame)->triangles.size())));
      points.push_back({triangle, {b1, b2}});
      expected.push_back(texels.Shade(triangle, {b1, b2}, 0.5, stats).radiance);
    }
    ForEachTarget([&] {
      TexelShader::Lately lately(*shader);
      BatchShader::Desk desk;
      // Batches of all sizes, what is left over from larger ones in the lanes that are not used.
      for (size_t first = 0, size = SurfaceBatch::kMost; first < points.size(); first += size) {
        size = std::min(1 + (first * 7 + size) % SurfaceBatch::kMost, points.size() - first);
        std::array<V3f, SurfaceBatch::kMost> radiance;
        batches.Shade(0, {points.data() + first, size}, lately, desk, {radiance.data(), size});
        for (size_t i = 0; i < size; ++i) {
          odd += desk.batch.is_odd[i];
          ++points_seen;
          ASSERT_EQ(radiance[i], expected[first + i]) << "point " << first + i;
        }
      }
    });
  }
  // Some of all, and not most.
  EXPECT_GT(odd, points_seen / 100);
  EXPECT_LT(odd, points_seen / 3);
}

TEST(BatchShader, LeavesToOthersWhatItDoesNotKnow) {
  RandomScene random(1);
  random.scene->materials[0].unlit = true;
  const RenderSettings settings = SquareSettings();
  const auto frame = BuildFrameScene(random.scene, 0, settings);
  ASSERT_TRUE(frame.ok()) << frame.status();
  const auto shader = Shader::Create(*frame, settings);
  ASSERT_TRUE(shader.ok());
  EXPECT_FALSE(BatchShader(*shader, TexelShader(*shader, settings, nullptr)).Takes(0));

  RandomScene lit(1);
  const auto lit_frame = BuildFrameScene(lit.scene, 0, settings);
  ASSERT_TRUE(lit_frame.ok());
  const auto takes = [&](const RenderSettings& by) {
    const auto made = Shader::Create(*lit_frame, by);
    EXPECT_TRUE(made.ok());
    return BatchShader(*made, TexelShader(*made, by, nullptr)).Takes(0);
  };
  EXPECT_TRUE(takes(settings));
  RenderSettings other = settings;
  other.lighting = LightingKind::kHeadlight;
  EXPECT_FALSE(takes(other));
  other = settings;
  other.shading_rate = 1;
  EXPECT_FALSE(takes(other));
  other = settings;
  other.occlusion.emplace();
  EXPECT_FALSE(takes(other));
}

}  // namespace
}  // namespace shutterline::engine::batch_shader_test
