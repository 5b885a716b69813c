// Hard case 44: a filter that is wider than a pixel shares light out, across the borders of tiles too, and
// loses none.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/job/output_channels.h"
#include "tests/support/frame_scene_builder.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/render/tile_integrator.h"

namespace shutterline::engine::filter_energy_test {
namespace {

constexpr int kSide = 96;  // Three tiles.

struct Filter {
  FilterKind kind;
  double radius;
};
constexpr Filter kFilters[] = {
    {FilterKind::kBox, 1},        {FilterKind::kBox, 2.3},          {FilterKind::kTriangle, 1},
    {FilterKind::kTriangle, 1.5}, {FilterKind::kGaussian, 1.5},     {FilterKind::kGaussian, 4},
    {FilterKind::kGaussian, 0.7}, {FilterKind::kBlackmanHarris, 2}, {FilterKind::kBlackmanHarris, 1.3}};

std::string Name(const RenderSettings& settings) {
  return std::string(ToString(settings.filter)) + " " + std::to_string(FilterRadius(settings)) + " " +
         std::string(ToString(settings.pattern));
}

FlatLook Look(const V3f& color, float alpha = 1) {
  FlatLook look;
  look.color = color;
  look.alpha = alpha;
  if (alpha < 1) look.alpha_mode = AlphaMode::kBlend;
  return look;
}

/// Small bright things across borders and corners of tiles: at rest, sliding, behind glass, and of colours
/// that vary.
FrameSceneBuilder BrightThings() {
  FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
  scene.AddRectangle(30.3, 31.1, 33.7, 33.9, 5, Look({50, 20, 3}));
  scene.AddRectangle(60.2, 40.6, 61.4, 42.9, 5, Look({0, 90, 7}), 9.3, 2.1);
  scene.AddRectangle(31.6, 60.2, 32.2, 70.1, 6, Look({5, 5, 60}), 0, -7.7);
  scene.AddRectangle(28.4, 32.2, 40.3, 32.8, 4, Look({2, 0, 8}, 0.3f));
  scene.AddRectangle(61.4, 41.1, 66.6, 44.3, 4, Look({1, 7, 0}, 0.6f), -2, 1);
  FlatLook smooth = Look({30, 30, 30});
  smooth.vertex_colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0.3f, 0.3f, 1, 1}};
  scene.AddTriangle({{{58, 60, 5}, {67, 63, 7}, {61, 70, 5}}}, smooth);
  scene.AddTriangle({{{62, 20, 5}, {67, 23, 7}, {66, 34, 5}}}, {{{60, 22, 5}, {64, 25, 7}, {66, 29, 5}}},
                    smooth);
  return scene;
}

RenderSettings Lines(PatternKind pattern) {
  RenderSettings settings;
  settings.width = settings.height = kSide;
  settings.pattern = pattern;
  settings.time_samples = 8;
  return settings;
}

Image Render(const FrameSceneBuilder& scene, const RenderSettings& settings, int tile_width = kTileSize,
             int tile_height = kTileSize, int threads = 1) {
  const auto integrator = MakeTileIntegrator(scene.Build(), 0, settings, 1);
  EXPECT_TRUE(integrator.ok()) << integrator.status();
  return RenderTiles(**integrator, kSide, kSide, tile_width, tile_height, threads);
}

std::array<double, 4> Energy(const Image& image) {
  std::array<double, 4> energy{};
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      for (size_t c = 0; c < 4; ++c) energy[c] += double(image.At(x, y)[c]);
    }
  }
  return energy;
}

TEST(FilterEnergy, Row44WideFilterAcrossTileBorder) {
  const FrameSceneBuilder scene = BrightThings();
  for (const PatternKind pattern : {PatternKind::k1h1v, PatternKind::k4h4v, PatternKind::kRgls}) {
    const std::array<double, 4> box = Energy(Render(scene, Lines(pattern)));
    for (const Filter& filter : kFilters) {
      RenderSettings settings = Lines(pattern);
      settings.filter = filter.kind;
      settings.filter_radius = filter.radius;
      const std::array<double, 4> wide = Energy(Render(scene, settings));
      for (size_t c = 0; c < 4; ++c) {
        EXPECT_NEAR(wide[c] / box[c], 1, 2e-7) << Name(settings) << " channel " << c;
      }
    }
  }
}

/// What a tile leaves to its neighbours is what these take, whatever tiles there are.
TEST(FilterEnergy, TilesAndThreadsDoNotMatter) {
  const FrameSceneBuilder scene = BrightThings();
  for (const Filter& filter : {Filter{FilterKind::kGaussian, 1.5}, Filter{FilterKind::kBlackmanHarris, 4}}) {
    RenderSettings settings = Lines(PatternKind::kRgls);
    settings.filter = filter.kind;
    settings.filter_radius = filter.radius;
    const Image whole = Render(scene, settings, kSide, kSide);
    const Image tiles = Render(scene, settings);
    const Image odd = Render(scene, settings, 17, 23);
    const Image threads = Render(scene, settings, kTileSize, kTileSize, 2);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        for (size_t c = 0; c < 4; ++c) {
          EXPECT_EQ(threads.At(x, y)[c], tiles.At(x, y)[c]);
          EXPECT_NEAR(tiles.At(x, y)[c], whole.At(x, y)[c], 1e-5) << x << " " << y;
          EXPECT_NEAR(odd.At(x, y)[c], whole.At(x, y)[c], 1e-5) << x << " " << y;
        }
      }
    }
  }
}

/// Where tiles choose their effort themselves, what they share out differs by the error that is aimed at.
TEST(FilterEnergy, ChosenEffortKeepsItUpToNoise) {
  const FrameSceneBuilder scene = BrightThings();
  RenderSettings settings = Lines(PatternKind::kAuto);
  settings.time_samples = std::nullopt;
  settings.target_error = 0.005;
  const std::array<double, 4> box = Energy(Render(scene, settings));
  settings.filter = FilterKind::kGaussian;
  const std::array<double, 4> wide = Energy(Render(scene, settings));
  for (size_t c = 0; c < 4; ++c) EXPECT_NEAR(wide[c] / box[c], 1, 0.01) << "channel " << c;
}

/// One colour everywhere stays that colour to the last bit, at the frame's edges and corners too, as the
/// apron sees what is beyond them.
TEST(FilterEnergy, AConstantFrameStaysConstant) {
  const V3f color(0.7f, 3.3f, 1e-3f);
  for (const double slide : {0.0, 6.5}) {
    FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
    // Two halves that meet in the frame, and reach beyond it.
    scene.AddRectangle(-30, -30, 41.3, 130, 5, Look(color), slide, slide);
    scene.AddRectangle(41.3, -30, 130, 130, 5, Look(color), slide, slide);
    for (const PatternKind pattern : {PatternKind::k2h2v, PatternKind::kRgls}) {
      for (const Filter& filter : kFilters) {
        RenderSettings settings = Lines(pattern);
        settings.filter = filter.kind;
        settings.filter_radius = filter.radius;
        const Image image = Render(scene, settings);
        for (int y = 0; y < kSide; ++y) {
          for (int x = 0; x < kSide; ++x) {
            const auto pixel = image.At(x, y);
            for (int c = 0; c < 3; ++c)
              ASSERT_EQ(pixel[size_t(c)], color[c]) << Name(settings) << x << "," << y;
            ASSERT_EQ(pixel[3], 1);
          }
        }
      }
    }
  }
}

/// Mattes and AOVs have the picture's weights: coverages add up to alpha, objects keep their areas.
TEST(FilterEnergy, MattesAreFilteredAsThePictureIs) {
  const FrameSceneBuilder scene = BrightThings();
  RenderSettings settings = Lines(PatternKind::kRgls);
  settings.aovs = {Aov::kDepth, Aov::kAlbedo};
  settings.mattes = {Matte::kMaterial};
  settings.matte_ranks = 16;
  const auto channels = OutputChannelsOf(settings);
  const auto render = [&] {
    std::vector<std::string> names;
    for (const OutputChannel& channel : channels) names.push_back(channel.name);
    const auto integrator = MakeTileIntegrator(scene.Build(), 0, settings, 1);
    EXPECT_TRUE(integrator.ok()) << integrator.status();
    Image image(kSide, kSide, names);
    const TileGrid grid{kSide, kSide};
    for (int t = 0; t < grid.Count(); ++t) {
      const TileRect tile = grid.Rect(t);
      std::vector<float> pixels(channels.size() * size_t(tile.Area()));
      RenderStats stats;
      (*integrator)->Render(tile, pixels, stats);
      EXPECT_EQ(stats.matte_overflows, 0);
      for (int64_t i = 0; i < tile.Area(); ++i) {
        std::copy_n(pixels.begin() + i * int64_t(channels.size()), channels.size(),
                    image.At(tile.x + int(i % tile.width), tile.y + int(i / tile.width)));
      }
    }
    return image;
  };
  const auto index = [&](const std::string& name) {
    for (size_t c = 0; c < channels.size(); ++c) {
      if (channels[c].name == name) return c;
    }
    ADD_FAILURE() << name;
    return size_t{0};
  };
  const Image box = render();
  settings.filter = FilterKind::kGaussian;
  const Image wide = render();
  const size_t depth = index("Z"), albedo = index("albedo.R"), first_rank = channels.size() - 2 * 16;
  double area = 0, wide_area = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const auto pixel = wide.At(x, y);
      double sum = 0;
      for (size_t c = first_rank; c < channels.size(); c += 2) sum += double(pixel[c + 1]);
      EXPECT_NEAR(sum, double(pixel[3]), 1e-6) << x << "," << y;
      EXPECT_EQ(std::isinf(pixel[depth]), pixel[3] == 0);
      area += double(box.At(x, y)[albedo]);
      wide_area += double(pixel[albedo]);
      // The nearest of all that the filter reaches.
      float nearest = std::numeric_limits<float>::infinity();
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (x + dx < 0 || y + dy < 0 || x + dx >= kSide || y + dy >= kSide) continue;
          nearest = std::min(nearest, box.At(x + dx, y + dy)[depth]);
        }
      }
      EXPECT_GE(pixel[depth], nearest * (1 - 1e-5f));
    }
  }
  EXPECT_NEAR(wide_area / area, 1, 1e-6);
}

}  // namespace
}  // namespace shutterline::engine::filter_energy_test
