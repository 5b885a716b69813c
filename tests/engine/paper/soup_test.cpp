// Random soups of moving triangles: the patch engine against exact slices at many instants. They share
// the patterns, the set-up of the tile and what a static line sees; all that concerns motion is two ways.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <random>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/resolved_tile.h"
#include "tests/support/rounds.h"
#include "tests/support/scalar_resolver.h"
#include "worker/engine/paper/resolver_paper.h"

namespace shutterline::engine {
namespace {

/// SHUTTERLINE_SOUPS in the environment asks for another number of soups, seeds 1 to it; ten thousand take
/// minutes.
int Soups() {
  const char* asked = std::getenv("SHUTTERLINE_SOUPS");
  return asked != nullptr ? std::atoi(asked) : Rounds(200);
}

std::shared_ptr<const FrameScene> Soup(uint64_t seed, int count, double speed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  FrameSceneBuilder builder(PerspectiveView(16, 16, 0.8, 0.1));
  for (int i = 0; i < count; ++i) {
    const V3d center(1.2 * unit(random), 1.2 * unit(random), -4 + 1.5 * unit(random));
    const V3d velocity(speed * unit(random), speed * unit(random), speed * unit(random));
    std::array<V3d, 3> open;
    std::array<V3d, 3> close;
    const double size = 0.3 + 0.7 * std::abs(unit(random));
    const bool moves = random() % 4 != 0;
    for (size_t k = 0; k < 3; ++k) {
      open[k] = center + V3d(unit(random), unit(random), unit(random)) * size;
      close[k] =
          moves ? open[k] + velocity + V3d(unit(random), unit(random), unit(random)) * (speed / 3) : open[k];
    }
    const FlatLook look{.double_sided = random() % 3 != 0};
    if (moves) {
      builder.AddViewTriangle(open, close, look);
    } else {
      builder.AddViewTriangle(open, look);
    }
  }
  return builder.Build();
}

TEST(PaperSoup, AgreesWithManyInstants) {
  const TileRect rect{4, 4, 8, 8};
  constexpr double kLargest = 5e-3;
  double largest = 0;
  double sum = 0;
  int64_t pixels = 0;
  const int soups = Soups();
  for (uint64_t seed = 1; seed <= uint64_t(soups); ++seed) {
    double largest_of_seed = 0;
    const int count = 2 + int(seed % 24);
    const auto frame = Soup(seed, count, 0.1 + 0.1 * double(seed % 8));
    RenderSettings settings = LineSettings(seed % 2 == 0 ? PatternKind::kRgls : PatternKind::k1h1v, 512);
    const ResolvedTile slices(*frame, rect, ScalarResolver(settings));
    const ResolverPaper paper(LinePattern::Get(settings.pattern), {.time_cells = 1 + int(seed % 5),
                                                                   .outline_tolerance = 2e-3,
                                                                   .depth_tolerance = 2e-4,
                                                                   .refinements = 12,
                                                                   .plane_halvings = 8});
    const ResolvedTile patches(*frame, rect, paper);
    for (int y = 0; y < rect.height; ++y) {
      for (int x = 0; x < rect.width; ++x) {
        double difference = 0;
        for (uint32_t i = 0; i < uint32_t(count); ++i) {
          difference = std::max(difference, std::abs(patches.Coverage(x, y, i) - slices.Coverage(x, y, i)));
        }
        sum += difference * difference;
        ++pixels;
        largest_of_seed = std::max(largest_of_seed, difference);
      }
    }
    EXPECT_LE(largest_of_seed, kLargest) << "seed " << seed;
    largest = std::max(largest, largest_of_seed);
  }
  const double rms = std::sqrt(sum / double(pixels));
  std::cout << soups << " soups: rms " << rms << ", largest " << largest << "\n";
  EXPECT_LE(rms, 4e-4);
}

}  // namespace
}  // namespace shutterline::engine
