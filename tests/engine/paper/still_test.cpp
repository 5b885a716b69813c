// What stands still costs one resolve and is that of the plain resolver to the last bit.
#include <gtest/gtest.h>

#include <random>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/resolved_tile.h"
#include "tests/support/scalar_resolver.h"

namespace shutterline::engine {
namespace {

std::shared_ptr<const FrameScene> Still(uint64_t seed, bool with_mover) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  FrameSceneBuilder builder(PerspectiveView(32, 32, 0.8, 0.1));
  for (int i = 0; i < 40; ++i) {
    const V3d center(unit(random), unit(random), -4 + unit(random));
    const auto corner = [&] { return center + V3d(unit(random), unit(random), unit(random)); };
    builder.AddViewTriangle({corner(), corner(), corner()});
  }
  // Something small that moves across the pixels (24..31, 2..5).
  if (with_mover) builder.AddRectangle(25, 3, 26, 4, 1, {}, 3, 0);
  return builder.Build();
}

RenderSettings Paper(PatternKind pattern, int time_cells) {
  RenderSettings settings = LineSettings(pattern, 16);
  settings.resolver = ResolverKind::kPaper;
  settings.time_cells = time_cells;
  return settings;
}

TEST(PaperStill, Row25BitEqualForAllCellsAndToSlices) {
  const TileRect rect{0, 0, 32, 32};
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto frame = Still(seed, false);
    const auto moving = Still(seed, true);
    // A power of two, so that both count in the same units.
    RenderSettings slice_settings = LineSettings(PatternKind::kRgls, 16);
    slice_settings.time_samples.reset();
    const ResolvedTile slices(*frame, rect, ScalarResolver(slice_settings));
    for (const int cells : {1, 3, 4, 64}) {
      const ResolvedTile patches(*frame, rect, Paper(PatternKind::kRgls, cells));
      const ResolvedTile beside(*moving, rect, Paper(PatternKind::kRgls, cells));
      ASSERT_EQ(patches.total(), slices.total());
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 32; ++x) {
          const bool near_mover = x >= 24 && y >= 2 && y <= 5;
          for (uint32_t i = 0; i < 40; ++i) {
            ASSERT_EQ(patches.Weight(x, y, i), slices.Weight(x, y, i)) << x << ", " << y;
            if (near_mover) continue;
            ASSERT_EQ(beside.Weight(x, y, i), slices.Weight(x, y, i)) << x << ", " << y;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace shutterline::engine
