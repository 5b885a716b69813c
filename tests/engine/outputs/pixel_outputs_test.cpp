// AOVs and mattes of the line integrator against closed forms and against renders of single objects.
#include "worker/engine/render/pixel_outputs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "common/cryptomatte/cryptomatte.h"
#include "common/image/image.h"
#include "common/job/output_channels.h"
#include "tests/support/frame_scene_builder.h"
#include "tests/support/rounds.h"
#include "worker/engine/render/tile_integrator.h"

namespace shutterline::engine {
namespace {

constexpr int kSide = 64;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Image Render(const FrameSceneBuilder& scene, RenderSettings settings, RenderStats* stats = nullptr) {
  settings.width = settings.height = kSide;
  const auto integrator = MakeTileIntegrator(scene.Build(), 0, settings, 1);
  EXPECT_TRUE(integrator.ok()) << integrator.status();
  std::vector<std::string> names;
  for (const OutputChannel& channel : OutputChannelsOf(settings)) names.push_back(channel.name);
  Image image(kSide, kSide, names);
  RenderStats unused;
  (*integrator)->Render({0, 0, kSide, kSide}, image.values(), stats != nullptr ? *stats : unused);
  return image;
}

float Value(const Image& image, int x, int y, const std::string& channel) {
  const auto found = std::find(image.channels().begin(), image.channels().end(), channel);
  EXPECT_NE(found, image.channels().end()) << channel;
  return image.At(x, y)[found - image.channels().begin()];
}

/// The coverage of a name, read as a compositor does: through ids alone, over all ranks.
float Coverage(const Image& image, int x, int y, const std::string& layer, const std::string& name) {
  float sum = 0;
  for (int rank = 0; rank < 2 * kMaxMatteRanks; ++rank) {
    const std::string part = layer + (rank / 2 < 10 ? "0" : "") + std::to_string(rank / 2);
    const std::string id = part + (rank % 2 == 0 ? ".R" : ".B");
    if (std::find(image.channels().begin(), image.channels().end(), id) == image.channels().end()) break;
    if (std::bit_cast<uint32_t>(Value(image, x, y, id)) == MatteIdBits(name)) {
      sum += Value(image, x, y, part + (rank % 2 == 0 ? ".G" : ".A"));
    }
  }
  return sum;
}

float SumOfCoverages(const Image& image, int x, int y) {
  double sum = 0;
  for (size_t c = 4; c < image.channels().size(); c += 2) sum += double(image.At(x, y)[c + 1]);
  return float(sum);
}

FlatLook Look(const V3f& color, float alpha = 1) {
  FlatLook look;
  look.color = color;
  look.alpha = alpha;
  if (alpha < 1) look.alpha_mode = AlphaMode::kBlend;
  return look;
}

/// Rectangles and triangles in motion, some of them see-through. `lit`: the one that is white, or -1: none.
FrameSceneBuilder Objects(uint32_t seed, int count, bool layers, int lit) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
  for (int i = 0; i < count; ++i) {
    const V3f color = i == lit ? V3f(1) : V3f(0);
    const float alpha = layers && i % 2 == 0 ? float(uniform(0.2, 0.9)) : 1.0f;
    const double x = uniform(-10, 60), y = uniform(-10, 60), far = uniform(1, 10);
    const double w = uniform(3, 40), h = uniform(3, 40);
    if (i % 3 == 0) {
      const double dx = uniform(-40, 40), dy = uniform(-40, 40), near = uniform(1, 10);
      scene.AddTriangle({{{x, y, far}, {x + w, y, near}, {x, y + h, far}}},
                        {{{x + dx, y + dy, near}, {x + w + dx, y, far}, {x, y + h + dy, far}}},
                        Look(color, alpha));
    } else {
      scene.AddRectangle(x, y, x + w, y + h, far, Look(color, alpha), uniform(-30, 30), uniform(-30, 30));
    }
  }
  return scene;
}

RenderSettings Mattes() {
  RenderSettings settings;
  settings.time_samples = 16;
  settings.mattes = {Matte::kObject};
  settings.matte_ranks = kMaxMatteRanks;
  return settings;
}

class MattesOf : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Surfaces, MattesOf, testing::Bool(),
                         [](const testing::TestParamInfo<bool>& parameter) {
                           return parameter.param ? "Layers" : "Opaque";
                         });

TEST_P(MattesOf, MovingObjectsMatchRendersOfThemAlone) {
  for (uint32_t seed = 1; seed <= uint32_t(Rounds(4)); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    constexpr int kCount = 9;
    const Image mattes = Render(Objects(seed, kCount, GetParam(), -1), Mattes());
    RenderSettings plain = Mattes();
    plain.mattes.clear();
    for (int object = 0; object < kCount; ++object) {
      // White among black ones: what is seen of it, by way of its colour.
      const Image alone = Render(Objects(seed, kCount, GetParam(), object), plain);
      const std::string name = "node_" + std::to_string(object);
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          ASSERT_NEAR(Coverage(mattes, x, y, "CryptoObject", name), alone.At(x, y)[0], 1.0 / 512)
              << name << " at " << x << ", " << y;
        }
      }
    }
  }
}

TEST_P(MattesOf, CoveragesAddUpToAlpha) {
  for (uint32_t seed = 11; seed < 11 + uint32_t(Rounds(10)); ++seed) {
    RenderStats stats;
    const Image image = Render(Objects(seed, 30, GetParam(), -1), Mattes(), &stats);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x)
        ASSERT_NEAR(SumOfCoverages(image, x, y), image.At(x, y)[3], 1e-6) << seed;
    }
    EXPECT_EQ(stats.matte_overflows, 0);
  }
}

TEST_P(MattesOf, RanksDescendAndWhatIsCutOffIsCounted) {
  RenderSettings settings = Mattes();
  const Image all = Render(Objects(3, 30, GetParam(), -1), settings);
  settings.matte_ranks = 3;
  RenderStats stats;
  const Image some = Render(Objects(3, 30, GetParam(), -1), settings, &stats);
  int64_t cut = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      for (size_t c = 4; c + 2 < all.channels().size(); c += 2)
        EXPECT_GE(all.At(x, y)[c + 1], all.At(x, y)[c + 3]);
      for (size_t c = 0; c < 10; ++c) EXPECT_EQ(some.At(x, y)[c], all.At(x, y)[c]);
      EXPECT_EQ(some.At(x, y)[10], 0);  // The fourth of three ranks.
      EXPECT_EQ(some.At(x, y)[11], 0);
      if (all.At(x, y)[11] > 0) ++cut;
    }
  }
  EXPECT_GT(cut, 0);
  EXPECT_EQ(stats.matte_overflows, cut);
}

TEST(PixelOutputs, ColoursAreTheSameBitsWithAndWithoutThem) {
  for (const bool layers : {false, true}) {
    RenderSettings plain;
    RenderSettings all;
    all.aovs = {Aov::kDepth,  Aov::kPosition, Aov::kNormal,   Aov::kMotion,
                Aov::kAlbedo, Aov::kSamples,  Aov::kObjectId, Aov::kMaterialId};
    all.mattes = {Matte::kObject, Matte::kMaterial};
    const FrameSceneBuilder scene = Objects(5, 20, layers, 3);
    const Image a = Render(scene, plain), b = Render(scene, all);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        for (int c = 0; c < 4; ++c) ASSERT_EQ(a.At(x, y)[c], b.At(x, y)[c]) << x << ", " << y;
      }
    }
  }
}

TEST(PixelOutputs, ARectangleHoldsWhatItIs) {
  FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
  scene.AddRectangle(-50, -50, 40.25, 100, 4, Look({0.5f, 0.25f, 1}));
  scene.AddRectangle(-50, -50, 150, 20.5, 2, Look({1, 1, 0}), 6, 0);
  RenderSettings settings;
  settings.aovs = {Aov::kDepth,  Aov::kPosition, Aov::kNormal,   Aov::kMotion,
                   Aov::kAlbedo, Aov::kSamples,  Aov::kObjectId, Aov::kMaterialId};
  const Image image = Render(scene, settings);

  // The still one alone.
  EXPECT_EQ(Value(image, 10, 40, "Z"), 4);
  EXPECT_NEAR(Value(image, 10, 40, "depth.mean"), 4, 1e-6);
  EXPECT_NEAR(Value(image, 10, 40, "N.Z"), 1, 1e-6);
  EXPECT_EQ(Value(image, 10, 40, "motion.X"), 0);
  EXPECT_NEAR(Value(image, 10, 40, "albedo.G"), 0.25, 1e-6);
  EXPECT_EQ(Value(image, 10, 40, "object-id"), 1);
  const auto view = PerspectiveView(kSide, kSide);
  EXPECT_NEAR(Value(image, 10, 40, "P.X"), (10.5 - view.center_x) / view.scale_x * 4, 1e-5);
  EXPECT_NEAR(Value(image, 10, 40, "P.Y"), (view.center_y - 40.5) / view.scale_y * 4, 1e-5);
  EXPECT_NEAR(Value(image, 10, 40, "P.Z"), -4, 1e-5);

  // The moving one alone.
  EXPECT_EQ(Value(image, 50, 10, "Z"), 2);
  EXPECT_NEAR(Value(image, 50, 10, "motion.X"), 6, 1e-5);
  EXPECT_NEAR(Value(image, 50, 10, "motion.Y"), 0, 1e-5);
  EXPECT_EQ(Value(image, 50, 10, "object-id"), 2);
  EXPECT_EQ(Value(image, 50, 10, "material-id"), 2);
  EXPECT_GE(Value(image, 50, 10, "samples.instants"), 2);

  // A pixel that each covers half of: places are means over what is covered, the nearest is the nearer.
  EXPECT_EQ(Value(image, 10, 20, "Z"), 2);
  EXPECT_NEAR(Value(image, 10, 20, "depth.mean"), 3, 1e-5);
  EXPECT_NEAR(Value(image, 10, 20, "motion.X"), 3, 1e-5);
  EXPECT_EQ(Value(image, 10, 20, "samples.pairs"), 2);
  // A quarter of a pixel: directions and places are whole, colour is premultiplied.
  EXPECT_NEAR(image.At(40, 40)[3], 0.25, 1e-6);
  EXPECT_NEAR(Value(image, 40, 40, "N.Z"), 1, 1e-6);
  EXPECT_NEAR(Value(image, 40, 40, "depth.mean"), 4, 1e-5);
  EXPECT_NEAR(Value(image, 40, 40, "albedo.B"), 0.25, 1e-6);
  // Nothing.
  EXPECT_EQ(Value(image, 60, 60, "Z"), kInfinity);
  EXPECT_EQ(Value(image, 60, 60, "depth.mean"), kInfinity);
  EXPECT_EQ(Value(image, 60, 60, "object-id"), 0);
  EXPECT_EQ(Value(image, 60, 60, "P.X"), 0);
}

TEST(PixelOutputs, PositionsAreThoseOfTheWorldWhereverTheCameraIs) {
  FrameView view = PerspectiveView(kSide, kSide);
  view.world_position = {10, 20, 30};
  view.world_axes = {V3d(0, 0, -1), V3d(0, 1, 0), V3d(1, 0, 0)};  // It looks along the world's x.
  FrameSceneBuilder scene(view);
  scene.AddRectangle(-50, -50, 150, 150, 5, Look({1, 1, 1}));
  RenderSettings settings;
  settings.aovs = {Aov::kPosition, Aov::kNormal};
  const Image image = Render(scene, settings);
  EXPECT_NEAR(Value(image, 32, 32, "P.X"), 15, 1e-5);
  EXPECT_NEAR(Value(image, 32, 32, "P.Y"), 20 - 0.5 / view.scale_y * 5, 1e-5);
  EXPECT_NEAR(Value(image, 32, 32, "P.Z"), 30 + 0.5 / view.scale_x * 5, 1e-5);
  EXPECT_NEAR(Value(image, 32, 32, "N.X"), -1, 1e-6);
}

TEST(PixelOutputs, MethodsWithoutThemSaySo) {
  RenderSettings settings;
  settings.aovs = {Aov::kDepth};
  settings.width = settings.height = kSide;
  for (const IntegratorKind kind : {IntegratorKind::kReference, IntegratorKind::kStochastic}) {
    settings.integrator = kind;
    const auto integrator = MakeTileIntegrator(Objects(1, 3, false, 0).Build(), 0, settings, 1);
    EXPECT_EQ(integrator.status().code(), absl::StatusCode::kUnimplemented);
  }
}

}  // namespace
}  // namespace shutterline::engine
