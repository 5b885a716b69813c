#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "tests/support/random_soup.h"
#include "worker/engine/occlusion/hemisphere_lines.h"
#include "worker/engine/occlusion/line_cover.h"
#include "worker/engine/occlusion/line_measure.h"
#include "worker/engine/occlusion/occluder_motion.h"

namespace shutterline::engine::parts_test {
namespace {

constexpr OcclusionPattern kPatterns[] = {OcclusionPattern::kPole, OcclusionPattern::kTilted};

TEST(HemisphereLines, HeadingsAreCosineAndSine) {
  for (int i = -2000; i <= 2000; ++i) {
    const double turns = i / 700.0;
    const Heading heading = HeadingOf(turns);
    EXPECT_NEAR(heading.cosine, std::cos(2 * std::numbers::pi * turns), 1e-14);
    EXPECT_NEAR(heading.sine, std::sin(2 * std::numbers::pi * turns), 1e-14);
  }
}

TEST(HemisphereLines, EachHasItsStrataOfSpaceAndShutter) {
  for (const OcclusionPattern pattern : kPatterns) {
    for (const int lines : {1, 2, 3, 4, 8, 12, 16, 100, 1024}) {
      OcclusionSettings settings;
      settings.lines = lines;
      settings.pattern = pattern;
      std::set<int> times;
      for (int i = 0; i < lines; ++i) {
        const HemisphereLine line = LineAt(settings, i, {0.9, 0.2, 0.1});
        EXPECT_LT(std::abs(line.lean), 1);
        times.insert(int(line.instant * lines));
      }
      EXPECT_EQ(times.size(), size_t(lines));
    }
  }
}

/// The share of a random disc of the unit disc that tilted or polar lines find is, on average, its area.
TEST(HemisphereLines, MeasureAreasOfTheDisc) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const double radius = 0.1 + 0.3 * unit(random), x = (1 - radius) * unit(random), y = 0;
    for (const OcclusionPattern pattern : kPatterns) {
      OcclusionSettings settings;
      settings.lines = 4;
      settings.pattern = pattern;
      double sum = 0;
      constexpr int kRounds = 3000, kSteps = 200;
      for (int round = 0; round < kRounds; ++round) {
        const LineShifts shifts{unit(random), unit(random), 0};
        const HemisphereLine line = LineAt(settings, round % 4, shifts);
        const auto [c, s] = line.heading;
        for (int k = 0; k < kSteps; ++k) {
          const int32_t a = int32_t(-kLineEnd + 2.0 * kLineEnd * k / kSteps);
          const int32_t b = int32_t(-kLineEnd + 2.0 * kLineEnd * (k + 1) / kSteps);
          const double l = 0.5 * (double(a) + double(b)) * kLineUnit, h = line.lean * std::sqrt(1 - l * l);
          const double px = l * c - h * s, py = l * s + h * c;
          if ((px - x) * (px - x) + (py - y) * (py - y) < radius * radius) {
            sum += double(ShareBelow(pattern, b) - ShareBelow(pattern, a)) / double(kWholeLine);
          }
        }
      }
      EXPECT_NEAR(sum / kRounds, radius * radius, 0.012) << "seed " << seed << ", pattern " << int(pattern);
    }
  }
}

TEST(LineMeasure, IsMonotoneAndTheIntegralOfItsDensity) {
  for (const OcclusionPattern pattern : kPatterns) {
    EXPECT_EQ(ShareBelow(pattern, -kLineEnd), 0);
    EXPECT_EQ(ShareBelow(pattern, 0), kWholeLine / 2);
    EXPECT_EQ(ShareBelow(pattern, kLineEnd), kWholeLine);
    constexpr int kSteps = 4000;
    double integral = 0;
    int64_t before = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double middle = std::numbers::pi * (i + 0.5) / kSteps, end = std::numbers::pi * (i + 1) / kSteps;
      integral += DensityAt(pattern, -std::cos(middle), std::sin(middle)) * std::numbers::pi / kSteps;
      const int64_t share = ShareBelow(pattern, int32_t(std::lround(-std::cos(end) * kLineEnd)));
      EXPECT_GE(share, before);
      EXPECT_NEAR(double(share) / double(kWholeLine), integral, 1e-6);
      before = share;
    }
  }
}

TEST(LineCover, IsTheUnionInAnyOrder) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    constexpr int kCells = 40;
    std::vector<bool> covered(kCells);
    std::vector<LineInterval> intervals;
    const int count = 1 + int(seed % 12);
    for (int i = 0; i < count; ++i) {
      int a = int(random() % (kCells + 1)), b = int(random() % (kCells + 1));
      if (a > b) std::swap(a, b);
      intervals.push_back({a, b});
      std::fill(covered.begin() + a, covered.begin() + b, true);
    }
    for (int turn = 0; turn < 3; ++turn) {
      LineCover cover;
      for (const LineInterval& interval : intervals) cover.Add(interval.begin, interval.end);
      std::vector<bool> found(kCells);
      int32_t last = -1;
      for (const LineInterval& interval : cover.intervals()) {
        EXPECT_GT(interval.begin, last);
        EXPECT_LT(interval.begin, interval.end);
        std::fill(found.begin() + interval.begin, found.begin() + interval.end, true);
        last = interval.end;
      }
      EXPECT_EQ(found, covered);
      for (int a = 0; a < kCells; ++a) {
        for (int b = a + 1; b <= kCells; ++b) {
          EXPECT_EQ(cover.Holds(a, b),
                    std::find(covered.begin() + a, covered.begin() + b, false) == covered.begin() + b);
        }
      }
      std::shuffle(intervals.begin(), intervals.end(), random);
    }
  }
}

TEST(OccluderMotion, BoxesHoldTrianglesAtAnyInstant) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    const auto frame = RandomSoup(seed, 80, /*curved=*/true);
    const V3d centre(1, -2, -7);
    for (const int spans : {1, 2, 8}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", spans " << spans);
      const OccluderMotion motion{*frame, true, 0.5, centre, spans};
      for (uint32_t i = 0; i < frame->triangles.size(); ++i) {
        const FramePrimitive& primitive = frame->primitives[frame->triangles[i].primitive];
        for (int step = 0; step <= 40; ++step) {
          const double place = step / 40.0 * spans;
          const int span = std::min(int(place), spans - 1);
          const double u = place - span;
          const MovingBox box = motion.Bound(i, span);
          for (const uint32_t vertex : frame->triangles[i].vertices) {
            const V3d p =
                frame->view.ViewFromRaster(frame->VertexAt(primitive, vertex, step / 40.0)) / 0.5 - centre;
            const double slack = 1e-12 * (1 + p.length());
            for (int axis = 0; axis < 3; ++axis) {
              ASSERT_GE(p[axis], (1 - u) * box.open.lower[axis] + u * box.close.lower[axis] - slack) << i;
              ASSERT_LE(p[axis], (1 - u) * box.open.upper[axis] + u * box.close.upper[axis] + slack) << i;
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::parts_test
