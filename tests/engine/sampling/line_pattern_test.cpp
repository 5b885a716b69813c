#include "worker/engine/sampling/line_pattern.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>
#include <vector>

namespace shutterline::engine {
namespace {

constexpr PatternKind kAll[] = {PatternKind::k1h1v, PatternKind::k2h2v,   PatternKind::k4h4v,
                                PatternKind::k8h8v, PatternKind::k16h16v, PatternKind::kRgls};

TEST(LinePattern, EveryPixelHoldsTheSameNumberOfSteps) {
  for (const PatternKind kind : kAll) {
    const LinePattern& pattern = LinePattern::Get(kind);
    for (const TileRect& rect : {TileRect{0, 0, 32, 32}, TileRect{96, 64, 17, 5}, TileRect{1, 2, 1, 1}}) {
      std::map<std::pair<int, int>, int> steps;
      for (const TileLine& line : pattern.LinesIn(rect)) {
        const bool major_is_x = pattern.families()[line.family].major_is_x;
        for (int step = line.first_step; step < line.end_step; ++step) {
          const int minor = pattern.MinorPixel(line, step);
          ++steps[major_is_x ? std::pair(step, minor) : std::pair(minor, step)];
        }
      }
      ASSERT_EQ(int64_t(steps.size()), rect.Area()) << ToString(kind);
      for (const auto& [pixel, count] : steps) EXPECT_EQ(count, pattern.StepsPerPixel()) << ToString(kind);
    }
  }
}

TEST(LinePattern, AStepStaysWithinItsPixel) {
  for (const PatternKind kind : kAll) {
    const LinePattern& pattern = LinePattern::Get(kind);
    for (const TileLine& line : pattern.LinesIn({32, 160, 32, 32})) {
      const LineFamily& family = pattern.families()[line.family];
      for (int step = line.first_step; step < line.end_step; ++step) {
        const int pixel = pattern.MinorPixel(line, step);
        for (const double along : {0.0, 1.0}) {
          const double minor = line.intercept + family.slope * (step + along);
          EXPECT_GE(minor, pixel);
          EXPECT_LE(minor, pixel + 1);
        }
      }
    }
  }
}

TEST(LinePattern, RectanglesAgreeOnTheLinesThatTheyShare) {
  for (const PatternKind kind : kAll) {
    const LinePattern& pattern = LinePattern::Get(kind);
    const TileRect left{64, 32, 32, 32};
    const TileRect right{96, 32, 32, 32};
    std::map<std::pair<int, int64_t>, TileLine> in_left;
    for (const TileLine& line : pattern.LinesIn(left)) in_left[{line.family, line.number}] = line;
    int shared = 0;
    for (const TileLine& line : pattern.LinesIn(right)) {
      const auto found = in_left.find({line.family, line.number});
      if (found == in_left.end()) continue;
      ++shared;
      EXPECT_EQ(found->second.instant_offset, line.instant_offset);
      const LineFamily& family = pattern.families()[line.family];
      // The same line of the raster plane, whose intercepts are relative to different corners.
      const double shift = family.major_is_x ? family.slope * 32 : -32.0;
      EXPECT_EQ(found->second.intercept + shift, line.intercept);
    }
    EXPECT_GT(shared, 0) << ToString(kind);
  }
}

TEST(LinePattern, RglsHas96LinesOfEachFamilyInATile) {
  std::map<int, int> lines;
  for (const TileLine& line : LinePattern::Get(PatternKind::kRgls).LinesIn({0, 0, 32, 32}))
    ++lines[line.family];
  // y = x/2 + k/2 enters a step of the tile for k = -31..63.
  EXPECT_EQ(lines[0], 95);
  EXPECT_EQ(lines[1], 95);
}

TEST(InstantOffset, LinesOfAPixelInterleaveEvenly) {
  for (const PatternKind kind : kAll) {
    const LinePattern& pattern = LinePattern::Get(kind);
    for (const TileRect& pixel : {TileRect{0, 0, 1, 1}, TileRect{517, 33, 1, 1}}) {
      const int n = pattern.StepsPerPixel();
      std::set<int> strata;
      for (const TileLine& line : pattern.LinesIn(pixel)) {
        EXPECT_GT(line.instant_offset, 0);
        EXPECT_LT(line.instant_offset, 1);
        strata.insert(int(line.instant_offset * n));
      }
      EXPECT_EQ(int(strata.size()), n) << ToString(kind) << ": two lines of a pixel share a stratum";
    }
  }
}

}  // namespace
}  // namespace shutterline::engine
