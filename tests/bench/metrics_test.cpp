#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/image/metrics.h"
#include "tests/bench/errors.h"
#include "tests/bench/pareto.h"
#include "tests/bench/tile_subset.h"
#include "tests/bench/wilson.h"
#include "tests/scenes/random.h"

namespace shutterline::bench {
namespace {

/// Noise of deviation `sigma` about `value`, in every channel.
Image Noisy(double value, double sigma, int height, scenes::Random& random) {
  Image image(kTileSize, height);
  for (float& v : image.values()) {
    v = float(value + sigma * std::sqrt(12.0) * (random.Uniform() - 0.5));
  }
  return image;
}

/// D of a picture that is off by a known amount has its square as its mean, however noisy the halves; the
/// naive error has their noise on top.
TEST(UnbiasedErrors, NoiseOfTheReferenceCancels) {
  const double offset = 0.01, sigma = 0.05;
  double sum = 0, naive = 0, standard_error = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    scenes::Random random(uint64_t(trial) + 1);
    const Image a = Noisy(0.5, sigma, 64, random), b = Noisy(0.5, sigma, 64, random);
    const Image test = Noisy(0.5 + offset, 0, 64, random);
    const UnbiasedError error = MeasureUnbiasedError(test, a, b).value();
    sum += error.d / kTrials;
    standard_error += error.standard_error / kTrials;
    naive += std::pow(Compare(test, a)->rmse, 2) / kTrials;
  }
  // The mean of the trials is as many times surer as the root of their number says.
  EXPECT_NEAR(sum, offset * offset, 4 * standard_error / std::sqrt(double(kTrials)));
  EXPECT_NEAR(naive, offset * offset + sigma * sigma, 0.01 * sigma * sigma);
}

/// A random method's own variance is part of its error, and bias² is what is left without it.
TEST(UnbiasedErrors, BiasIsToldFromVariance) {
  const double offset = 0.02, sigma = 0.1;
  scenes::Random random(99);
  ReferenceHalves reference;
  reference.a = Noisy(0.5, 0.01, 512, random);
  reference.b = Noisy(0.5, 0.01, 512, random);
  std::vector<Image> pictures;
  for (int i = 0; i < 5; ++i) pictures.push_back(Noisy(0.5 + offset, sigma, 512, random));
  const BenchMasks none{{}, {}, {}};
  const ErrorFigures figures = MeasureErrors(pictures, reference, none, 1).value();
  EXPECT_NEAR(figures.whole.d, offset * offset + sigma * sigma, 0.02 * sigma * sigma);
  EXPECT_NEAR(figures.bias_squared, offset * offset, 0.3 * offset * offset);
}

TEST(UnbiasedErrors, NotANumberFails) {
  scenes::Random random(1);
  ReferenceHalves reference;
  reference.a = reference.b = Noisy(0.5, 0, 32, random);
  std::vector<Image> pictures = {reference.a};
  pictures[0].values()[17] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(MeasureErrors(pictures, reference, {}, 1).ok());
  pictures[0].values()[17] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(MeasureErrors(pictures, reference, {}, 1).ok());
}

TEST(Pareto, KeepsWhatNoOtherBeats) {
  const TimeErrorCurve curve({{4, 0.01}, {1, 0.1}, {2, 0.2}, {8, 0.02}, {1, 0.3}, {16, 0.001}});
  ASSERT_EQ(curve.envelope().size(), 3u);
  EXPECT_EQ(curve.envelope()[0].seconds, 1);
  EXPECT_EQ(curve.envelope()[0].error, 0.1);
  EXPECT_EQ(curve.envelope()[1].seconds, 4);
  EXPECT_EQ(curve.envelope()[2].error, 0.001);
}

/// Error ∝ time^(−2/3) is a straight line in log-log: what is read off between two runs lies on it.
TEST(Pareto, ReadsPowerLawsExactly) {
  const auto error = [](double seconds) { return 0.1 * std::pow(seconds, -2.0 / 3); };
  const TimeErrorCurve curve({{1, error(1)}, {10, error(10)}, {100, error(100)}});
  for (const double seconds : {1.0, 1.7, 9.0, 10.0, 55.5, 100.0}) {
    const Reading time = curve.SecondsFor(error(seconds) * (1 + 1e-12));
    EXPECT_NEAR(time.value, seconds, 1e-9 * seconds);
    const Reading back = curve.ErrorWithin(seconds);
    EXPECT_EQ(back.kind, Reading::Kind::kExact);
    EXPECT_NEAR(back.value, error(seconds), 1e-9);
  }
}

TEST(Pareto, NothingIsExtrapolated) {
  const TimeErrorCurve curve({{1, 0.1}, {10, 0.01}, {30, 0.02}});
  // Never reached: longer than the longest run, also where that is off the envelope.
  EXPECT_EQ(curve.SecondsFor(0.005).kind, Reading::Kind::kAtLeast);
  EXPECT_EQ(curve.SecondsFor(0.005).value, 30);
  EXPECT_EQ(curve.SecondsFor(0.005).ToString(), "> 30");
  EXPECT_EQ(curve.SecondsFor(0.5).kind, Reading::Kind::kAtMost);
  EXPECT_EQ(curve.SecondsFor(0.5).value, 1);
  EXPECT_EQ(curve.ErrorWithin(0.5).kind, Reading::Kind::kNone);
  EXPECT_EQ(curve.ErrorWithin(100).kind, Reading::Kind::kAtMost);
  EXPECT_EQ(TimeErrorCurve({}).SecondsFor(0.1).kind, Reading::Kind::kNone);
}

TEST(Pareto, RatiosKeepWhatIsKnown) {
  using Kind = Reading::Kind;
  EXPECT_EQ(Ratio({Kind::kExact, 6}, {Kind::kExact, 2}).value, 3);
  EXPECT_EQ(Ratio({Kind::kAtLeast, 6}, {Kind::kExact, 2}).kind, Kind::kAtLeast);
  EXPECT_EQ(Ratio({Kind::kExact, 6}, {Kind::kAtMost, 2}).kind, Kind::kAtLeast);
  EXPECT_EQ(Ratio({Kind::kAtLeast, 6}, {Kind::kAtMost, 2}).kind, Kind::kAtLeast);
  EXPECT_EQ(Ratio({Kind::kAtMost, 6}, {Kind::kExact, 2}).kind, Kind::kAtMost);
  EXPECT_EQ(Ratio({Kind::kAtLeast, 6}, {Kind::kAtLeast, 2}).kind, Kind::kNone);
  EXPECT_EQ(Ratio({}, {Kind::kExact, 2}).kind, Kind::kNone);
}

TEST(Pareto, GeometricMeans) {
  EXPECT_NEAR(GeometricMean({2, 8}).value(), 4, 1e-12);
  EXPECT_FALSE(GeometricMean({}).has_value());
}

/// The interval's ends are where the score test just does not reject: |p̂ − p| = z √(p (1 − p) / n).
TEST(Wilson, EndsSolveTheScoreTest) {
  for (const auto& [k, n] : {std::pair<int64_t, int64_t>{0, 10}, {1, 10}, {5, 10}, {10, 10}, {999, 1000}}) {
    const Interval interval = WilsonInterval(k, n);
    const double p_hat = double(k) / double(n);
    for (const double p : {interval.low, interval.high}) {
      if (p == 0 || p == 1) continue;
      EXPECT_NEAR(std::abs(p_hat - p), 1.959963984540054 * std::sqrt(p * (1 - p) / double(n)), 1e-12);
    }
    EXPECT_LE(interval.low, p_hat);
    EXPECT_GE(interval.high, p_hat);
  }
}

/// Published examples: 5 of 10, and no failure in 10.
TEST(Wilson, KnownValues) {
  EXPECT_NEAR(WilsonInterval(5, 10).low, 0.2366, 5e-5);
  EXPECT_NEAR(WilsonInterval(5, 10).high, 0.7634, 5e-5);
  EXPECT_NEAR(WilsonInterval(10, 10).low, 0.7225, 5e-5);
  EXPECT_EQ(WilsonInterval(10, 10).high, 1);
  EXPECT_EQ(WilsonInterval(0, 0).low, 0);
  EXPECT_EQ(WilsonInterval(0, 0).high, 1);
}

TEST(Tiles, OneOfEverySquare) {
  const TileSubset subset = StratifiedTiles(1024, 768, 4, 7);
  EXPECT_EQ(subset.tiles.size(), 48u);
  EXPECT_EQ(subset.tiles_in_frame, 768);
  EXPECT_DOUBLE_EQ(subset.Share(), 1.0 / 16);
  std::vector<int> squares;
  for (const TileRect& tile : subset.tiles) {
    EXPECT_EQ(tile.Area(), 1024);
    squares.push_back(tile.y / 128 * 8 + tile.x / 128);
  }
  for (int i = 0; i < 48; ++i) EXPECT_EQ(squares[size_t(i)], i);
  EXPECT_EQ(StratifiedTiles(1024, 768, 1, 1).tiles.size(), 768u);
  EXPECT_EQ(StratifiedTiles(1024, 768, 5, 7).tiles.size(), 7u * 5u);
}

TEST(Tiles, ParallelForDoesEverythingOnce) {
  std::vector<int> done(1000);
  ParallelFor(1000, 3, [&](int i, int) { ++done[size_t(i)]; });
  for (const int count : done) EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace shutterline::bench
