#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <map>
#include <random>
#include <span>

#include "common/job/render_settings.h"
#include "tests/scenes/scene_generators.h"
#include "tests/support/occlusion_rays.h"
#include "tests/support/rounds.h"
#include "worker/engine/occlusion/ambient_occlusion.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"

namespace shutterline::engine::rays_test {
namespace {

std::shared_ptr<const FrameScene> Frame(const std::string& name) {
  auto glb = scenes::GenerateGlb(name);
  if (!glb.ok()) return nullptr;
  const auto scene = ImportGltf(MemoryAssetSource("scene.glb", {{"scene.glb", *std::move(glb)}}));
  if (!scene.ok()) return nullptr;
  const auto frame = BuildFrameScene(*scene, 3, RenderSettings());
  return frame.ok() ? *frame : nullptr;
}

struct SurfacePoint {
  uint32_t triangle;
  double b1, b2;
};

/// Anywhere on the triangles, on whichever side the camera is.
std::vector<SurfacePoint> RandomPoints(const FrameScene& frame, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<SurfacePoint> points;
  for (int i = 0; i < count; ++i) {
    double b1 = unit(random), b2 = unit(random);
    if (b1 + b2 > 1) b1 = 1 - b1, b2 = 1 - b2;
    points.push_back({uint32_t(random() % frame.triangles.size()), b1, b2});
  }
  return points;
}

struct Case {
  const char* scene;
  bool motion;
  std::optional<double> radius;
  OcclusionFalloff falloff;
};

TEST(OcclusionAgainstRays, AgreeOnGeneratedScenes) {
  constexpr int kPoints = 60, kRays = 4096;
  constexpr uint64_t kSeed = 5;
  const Case cases[] = {{"chess", false, std::nullopt, OcclusionFalloff::kNone},
                        {"chess", true, std::nullopt, OcclusionFalloff::kNone},
                        {"chess", true, 0.1, OcclusionFalloff::kLinear},
                        {"armadillo", false, 0.5, OcclusionFalloff::kQuadratic},
                        {"armadillo", true, std::nullopt, OcclusionFalloff::kNone},
                        {"armadillo", true, 0.5, OcclusionFalloff::kLinear}};
  std::map<std::string, std::shared_ptr<const FrameScene>> frames;
  // For what sanitizers look at, three will do.
  const size_t count = size_t(Rounds(8)) < 8 ? 3 : std::size(cases);
  for (const Case& c : std::span(cases).first(count)) {
    SCOPED_TRACE(testing::Message() << c.scene << ", motion " << c.motion << ", fall-off " << int(c.falloff)
                                    << ", seed " << kSeed);
    auto& frame = frames[c.scene];
    if (frame == nullptr) frame = Frame(c.scene);
    ASSERT_NE(frame, nullptr);
    OcclusionSettings settings;
    settings.lines = 64;
    settings.motion = c.motion;
    settings.radius = c.radius;
    settings.falloff = c.falloff;
    const auto rays = OcclusionRays::Create(frame, settings, 2);
    ASSERT_TRUE(rays.ok());
    const std::vector<SurfacePoint> points = RandomPoints(*frame, kPoints, kSeed);
    std::vector<double> truths;
    for (const SurfacePoint& p : points) {
      truths.push_back(rays->At(p.triangle, p.b1, p.b2, kRays, p.triangle));
    }
    for (const OcclusionPattern pattern : {OcclusionPattern::kPole, OcclusionPattern::kTilted}) {
      settings.pattern = pattern;
      const auto lines = AmbientOcclusion::Create(frame, settings, 2);
      ASSERT_TRUE(lines.ok());
      double squares = 0, sum = 0;
      for (size_t i = 0; i < points.size(); ++i) {
        const SurfacePoint& p = points[i];
        const double difference = lines->At(p.triangle, p.b1, p.b2) - truths[i];
        EXPECT_LT(std::abs(difference), 0.05) << p.triangle << " " << p.b1 << " " << p.b2;
        squares += difference * difference;
        sum += difference;
      }
      EXPECT_LT(std::sqrt(squares / kPoints), 0.008) << int(pattern);
      EXPECT_LT(std::abs(sum / kPoints), 0.002) << int(pattern);
    }
  }
}

/// The mean over all shifts is the truth, whatever a point sees: few lines, shifted at random, have no bias.
TEST(OcclusionAgainstRays, ShiftedLinesHaveNoBias) {
  const auto frame = Frame("chess");
  ASSERT_NE(frame, nullptr);
  OcclusionSettings settings;
  settings.lines = 3;
  const auto rays = OcclusionRays::Create(frame, settings, 2);
  ASSERT_TRUE(rays.ok());
  constexpr uint64_t kSeed = 11;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const OcclusionPattern pattern : {OcclusionPattern::kPole, OcclusionPattern::kTilted}) {
    settings.pattern = pattern;
    const auto lines = AmbientOcclusion::Create(frame, settings, 2);
    ASSERT_TRUE(lines.ok());
    for (const SurfacePoint& p : RandomPoints(*frame, 8, kSeed)) {
      constexpr int kShifts = 1500;
      double sum = 0, squares = 0;
      for (int i = 0; i < kShifts; ++i) {
        const double open = lines->At(p.triangle, p.b1, p.b2, {unit(random), unit(random), unit(random)});
        sum += open;
        squares += open * open;
      }
      const double mean = sum / kShifts;
      const double error = std::sqrt(std::max(0.0, squares / kShifts - mean * mean) / kShifts);
      EXPECT_NEAR(mean, rays->At(p.triangle, p.b1, p.b2, 16384, p.triangle), 4 * error + 0.002)
          << "seed " << kSeed << ", triangle " << p.triangle << ", pattern " << int(pattern);
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::rays_test
