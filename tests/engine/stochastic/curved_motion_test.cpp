// Motion on curves and in pieces, against two judges: the oracle in double precision, sample by sample, and
// the tracer, whole pictures.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/engine/stochastic/stochastic_test_util.h"
#include "tests/support/point_oracle.h"
#include "worker/engine/reference/embree_tracer.h"
#include "worker/engine/stochastic/sample_keys.h"

namespace shutterline::engine {
namespace {

constexpr int kSide = 40;

struct Curve {
  int degree = 1, pieces = 1;
};
constexpr Curve kCurves[] = {{1, 2}, {1, 8}, {2, 1}, {2, 4}, {3, 1}, {3, 2}};

/// Triangles that wander through the view on curves; with `straightened`, straight from the same beginnings
/// to the same ends.
std::shared_ptr<const FrameScene> CurvedFrame(uint32_t seed, const Curve& curve, bool straightened = false) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  FrameSceneBuilder builder(PerspectiveView(kSide, kSide));
  for (int i = 0; i < 24; ++i) {
    const V3d center(uniform(-1.5, 1.5), uniform(-1.5, 1.5), uniform(-7, -2.5));
    const double size = uniform(0.2, 1);
    std::vector<RasterPoint> points;
    const int last = curve.degree * curve.pieces;
    for (int vertex = 0; vertex < 3; ++vertex) {
      V3d at = center + V3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)) * size;
      for (int k = 0; k <= last; ++k) {
        if (!straightened || k == 0 || k == last) points.push_back(builder.Raster(at));
        at += V3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)) * (1.5 / std::sqrt(double(last)));
      }
    }
    const FlatLook look{.color = V3f(float(i % 3 == 0), float(i % 3 == 1), float(i % 3 == 2)),
                        .double_sided = i % 4 != 0};
    builder.AddCurvedMesh(points, straightened ? 1 : curve.degree, straightened ? 1 : curve.pieces,
                          {{0, 1, 2}}, look);
  }
  return builder.Build();
}

TEST(StochasticCurvedMotion, SamplesSeeWhatTheOracleSees) {
  for (const Curve& curve : kCurves) {
    for (const uint32_t seed : {41u, 42u}) {
      SCOPED_TRACE(testing::Message()
                   << "degree " << curve.degree << ", " << curve.pieces << " pieces, seed " << seed);
      constexpr int kSpp = 16;
      const auto frame = CurvedFrame(seed, curve);
      const Image image = RenderTiles(*MakeStochastic(frame, kSpp), kSide, kSide);
      const StratifiedPattern pattern(0, 0, kSpp);
      int different = 0;
      int covered = 0;
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          int counts[3] = {0, 0, 0};
          for (int s = 0; s < kSpp; ++s) {
            const StratifiedPoint p = pattern.At(x, y, s);
            const auto seen = SeeAt(*frame, x + double(p.x), y + double(p.y), double(p.t));
            if (seen) ++counts[seen->triangle % 3];
          }
          for (int c = 0; c < 3; ++c) {
            covered += counts[c];
            different += std::abs(counts[c] - int(std::lround(image.At(x, y)[c] * kSpp)));
          }
        }
      }
      EXPECT_GT(covered, 1000);
      // Samples within a rounding of an edge or of a crossing of depths count twice.
      EXPECT_LE(different, 8);
    }
  }
}

/// Twice the same frame with two seeds each by the integrator and by the tracer: the mean over pixels of
/// (a − r)(a' − r') is the squared difference of what they converge to, whatever their noise, and its
/// scatter over pixels says how far to believe it.
struct SquaredDifference {
  double mean = 0, standard_error = 0;
};
SquaredDifference AgainstTracer(const std::shared_ptr<const FrameScene>& frame,
                                const std::shared_ptr<const FrameScene>& traced) {
  RenderSettings settings;
  settings.width = settings.height = kSide;
  settings.integrator = IntegratorKind::kReference;
  settings.spp = 128;
  Image differences[2];
  for (const uint64_t seed : {1u, 2u}) {
    settings.seed = seed;
    const auto tracer = EmbreeTracer::Create(traced, 0, settings, 1);
    EXPECT_TRUE(tracer.ok()) << tracer.status();
    Image& difference = differences[seed - 1];
    difference = RenderTiles(*MakeStochastic(frame, settings.spp, seed), kSide, kSide);
    const Image reference = RenderTiles(**tracer, kSide, kSide);
    for (size_t i = 0; i < difference.values().size(); ++i) difference.values()[i] -= reference.values()[i];
  }
  double sum = 0;
  double squares = 0;
  const size_t count = differences[0].values().size();
  for (size_t i = 0; i < count; ++i) {
    const double product = double(differences[0].values()[i]) * double(differences[1].values()[i]);
    sum += product;
    squares += product * product;
  }
  const double mean = sum / double(count);
  return {mean, std::sqrt((squares / double(count) - mean * mean) / double(count))};
}

TEST(StochasticCurvedMotion, ConvergesToWhatTheTracerSees) {
  for (const Curve& curve : kCurves) {
    for (const uint32_t seed : {51u, 52u}) {
      SCOPED_TRACE(testing::Message()
                   << "degree " << curve.degree << ", " << curve.pieces << " pieces, seed " << seed);
      const auto frame = CurvedFrame(seed, curve);
      const SquaredDifference same = AgainstTracer(frame, frame);
      // The tracer's rays meet straight pieces that are 0.01 px from the curve.
      EXPECT_LE(same.mean, 4.5 * same.standard_error + 1e-6);
      EXPECT_LE(same.standard_error, 1e-5) << "too noisy to show anything";
      // It would tell curves from chords.
      if (seed != 51) continue;
      EXPECT_GE(AgainstTracer(frame, CurvedFrame(seed, curve, true)).mean, 1e-3);
    }
  }
}

TEST(StochasticCurvedMotion, ClosedMeshesOnCurvesHaveNoGaps) {
  // A square around the picture, cut into a fan about an inner vertex that wanders; its border stands still.
  for (uint32_t seed = 1; seed <= 24; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const Curve& curve = kCurves[seed % std::size(kCurves)];
    FrameSceneBuilder builder(PerspectiveView(kSide, kSide));
    std::vector<RasterPoint> points;
    const auto add = [&](double x, double y, double reach) {
      for (int k = 0; k <= curve.degree * curve.pieces; ++k) {
        points.push_back(builder.Raster(
            Corner{x + reach * unit(random), y + reach * unit(random), reach > 0 ? 4 + unit(random) : 4}));
      }
    };
    add(-8, -8, 0), add(50, -8, 0), add(50, 50, 0), add(-8, 50, 0), add(20, 20, 18);
    builder.AddCurvedMesh(points, curve.degree, curve.pieces, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
    const Image image = RenderTiles(*MakeStochastic(builder.Build(), 64, seed), kSide, kSide);
    for (int i = 0; i < kSide * kSide; ++i) {
      ASSERT_EQ(image.At(i % kSide, i / kSide)[3], 1) << "seed " << seed << ", pixel " << i;
    }
  }
}

}  // namespace
}  // namespace shutterline::engine
