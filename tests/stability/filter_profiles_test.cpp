// What filters make of edges, by closed forms, and of random scenes, by lines and by rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/render_tiles.h"
#include "tests/support/rounds.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/sampling/pixel_filter.h"

namespace shutterline::engine::filter_profiles_test {
namespace {

constexpr int kSide = 40;

struct Filter {
  FilterKind kind;
  double radius;
};
constexpr Filter kFilters[] = {{FilterKind::kBox, 1.5},      {FilterKind::kTriangle, 1},
                               {FilterKind::kTriangle, 2},   {FilterKind::kGaussian, 1.5},
                               {FilterKind::kGaussian, 2.4}, {FilterKind::kBlackmanHarris, 2},
                               {FilterKind::kBox, 0.8},      {FilterKind::kBlackmanHarris, 4}};

/// What a pixel takes of all that lies before x, pixels from its middle: the integral of the curve divided by
/// the sum of its translates.
class Profile {
 public:
  explicit Profile(const Filter& filter) : filter_(filter) {
    const auto curve = [&](double x) {
      constexpr double kStep = 1e-4;
      return FilterIntegral(filter.kind, filter.radius, x + kStep) -
             FilterIntegral(filter.kind, filter.radius, x - kStep);
    };
    sums_.push_back(0);
    for (double x = -filter.radius + 0.5 / kParts; x < filter.radius; x += 1.0 / kParts) {
      double all = 0;
      for (int k = -8; k <= 8; ++k) all += curve(x + k);
      sums_.push_back(sums_.back() + curve(x) / all / kParts);
    }
  }
  double At(double x) const {
    const double at = std::clamp((x + filter_.radius) * kParts, 0.0, double(sums_.size() - 1));
    const auto i = std::min(size_t(at), sums_.size() - 2);
    return std::lerp(sums_[i], sums_[i + 1], at - double(i));
  }

 private:
  static constexpr int kParts = 2000;
  Filter filter_;
  std::vector<double> sums_;
};

RenderSettings Lines(PatternKind pattern, const Filter& filter) {
  RenderSettings settings;
  settings.width = settings.height = kSide;
  settings.pattern = pattern;
  settings.time_samples = 8;
  settings.filter = filter.kind;
  settings.filter_radius = filter.radius;
  return settings;
}

Image Render(const FrameSceneBuilder& scene, const RenderSettings& settings) {
  const auto integrator = MakeTileIntegrator(scene.Build(), 0, settings, 1);
  EXPECT_TRUE(integrator.ok()) << integrator.status();
  return RenderTiles(**integrator, kSide, kSide);
}

/// Half of the lines cross the edge: they have the filter's integral at the edge. The others run along it: of
/// horizontal and vertical ones, the strip of each is on one side of it; of rotated ones, the edge cuts the
/// strip.
TEST(FilterProfiles, EdgesHaveTheFiltersIntegral) {
  for (const double edge : {20.31, 32.0, 5.62, 0.2, 31.77}) {
    for (const bool across : {false, true}) {
      FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
      if (across) {
        scene.AddRectangle(-50, -50, 100, edge, 5);
      } else {
        scene.AddRectangle(-50, -50, edge, 100, 5);
      }
      for (const Filter& filter : kFilters) {
        const Profile profile(filter);
        // A box may end within a cell, in which shares are taken as constant.
        const double tolerance = filter.kind == FilterKind::kBox ? 1e-3 : 1e-4;
        for (const PatternKind pattern : {PatternKind::k1h1v, PatternKind::k4h4v, PatternKind::kRgls}) {
          const Image image = Render(scene, Lines(pattern, filter));
          const double lines = pattern == PatternKind::k1h1v ? 1 : pattern == PatternKind::k4h4v ? 4 : 2;
          const double before = std::floor(edge * lines) / lines;
          const double part = (edge - before) * lines;
          for (int i = 0; i < kSide; ++i) {
            const double middle = i + 0.5;
            const double crossing = profile.At(edge - middle);
            const double here = profile.At(before - middle), next = profile.At(before + 1 / lines - middle);
            const double along = pattern == PatternKind::kRgls ? std::lerp(here, next, part)
                                 : part > 0.5                  ? next
                                                               : here;
            const float alpha = across ? image.At(17, i)[3] : image.At(i, 17)[3];
            ASSERT_NEAR(double(alpha), 0.5 * (crossing + along), tolerance)
                << ToString(filter.kind) << " " << filter.radius << " " << ToString(pattern) << " edge "
                << edge << (across ? " across" : " along") << " pixel " << i;
          }
        }
      }
    }
  }
}

/// An edge that slides at constant speed from a to b: the mean of the profile over its path.
TEST(FilterProfiles, SlidingEdgesHaveTheMeanOfIt) {
  FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
  scene.AddRectangle(-200, -50, 14, 100, 5, {}, 12);
  for (const Filter& filter : kFilters) {
    RenderSettings settings = Lines(PatternKind::k4h4v, filter);
    settings.time_samples = 128;
    const Image image = Render(scene, settings);
    const Profile profile(filter);
    for (int i = 0; i < kSide; ++i) {
      double mean = 0;
      for (int k = 0; k < 1000; ++k) mean += profile.At(14 + 12 * (k + 0.5) / 1000 - (i + 0.5)) / 1000;
      EXPECT_NEAR(double(image.At(i, 33)[3]), mean, 2e-3) << ToString(filter.kind) << " pixel " << i;
    }
  }
}

/// Moving, still and see-through triangles of colours that vary, large enough for lines to see them well.
FrameSceneBuilder Mixture(uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
  for (int i = 0; i < 14; ++i) {
    FlatLook look;
    for (int k = 0; k < 3; ++k) {
      look.vertex_colors.push_back(
          {float(uniform(0, 1)), float(uniform(0, 1)), float(uniform(0, 1)), i % 4 == 0 ? 0.5f : 1.0f});
    }
    if (i % 4 == 0) look.alpha_mode = AlphaMode::kBlend;
    const double x = uniform(-5, 40), y = uniform(-5, 40), far = uniform(2, 9);
    const std::array<Corner, 3> open{{{x, y, far},
                                      {x + uniform(5, 20), y + uniform(-5, 5), far},
                                      {x + uniform(-5, 5), y + uniform(5, 20), far}}};
    std::array<Corner, 3> close = open;
    for (Corner& corner : close) {
      corner.x += uniform(-8, 8);
      corner.y += uniform(-8, 8);
    }
    if (i % 2 == 0) {
      scene.AddTriangle(open, close, look);
    } else {
      scene.AddTriangle(open, look);
    }
  }
  return scene;
}

TEST(FilterProfiles, LinesAgreeWithRays) {
  for (uint32_t seed = 1; seed <= uint32_t(Rounds(2)); ++seed) {
    const FrameSceneBuilder scene = Mixture(seed);
    const Image box = Render(scene, Lines(PatternKind::k8h8v, {FilterKind::kBox, 0.5}));
    for (const Filter& filter : {Filter{FilterKind::kTriangle, 1}, Filter{FilterKind::kGaussian, 1.5},
                                 Filter{FilterKind::kBlackmanHarris, 2}, Filter{FilterKind::kBox, 1.2}}) {
      RenderSettings settings = Lines(PatternKind::k8h8v, filter);
      settings.time_samples = 32;
      const Image lines = Render(scene, settings);
      settings.integrator = IntegratorKind::kReference;
      settings.spp = 256;
      const Image a = Render(scene, settings);
      settings.seed = 1;
      const Image b = Render(scene, settings);
      // The noise of two independent pictures cancels.
      double squares = 0, box_squares = 0;
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          for (size_t c = 0; c < 4; ++c) {
            const double first = double(a.At(x, y)[c]), second = double(b.At(x, y)[c]);
            squares += (double(lines.At(x, y)[c]) - first) * (double(lines.At(x, y)[c]) - second);
            box_squares += (double(box.At(x, y)[c]) - first) * (double(box.At(x, y)[c]) - second);
          }
        }
      }
      const double count = 4.0 * kSide * kSide;
      EXPECT_LT(std::sqrt(std::max(squares, 0.0) / count), 0.002)
          << "seed " << seed << " " << ToString(filter.kind) << " " << filter.radius;
      EXPECT_GT(std::sqrt(box_squares / count), 0.01) << "the filter makes no difference";
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::filter_profiles_test
