#include "worker/engine/scene/keyframes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace shutterline::engine::keyframes_test {
namespace {

AnimationChannel Channel(AnimatedPath path, Interpolation interpolation, std::vector<float> times,
                         std::vector<float> values) {
  AnimationChannel channel;
  channel.node = 0;
  channel.path = path;
  channel.interpolation = interpolation;
  const size_t per_key = values.size() / times.size();
  channel.width = int(interpolation == Interpolation::kCubicSpline ? per_key / 3 : per_key);
  channel.times = std::move(times);
  channel.values = std::move(values);
  return channel;
}

double Scalar(const AnimationChannel& channel, double time) {
  std::array<double, 3> value{};
  SampleChannel(channel, time, value);
  return value[0];
}

Quatd Rotation(const AnimationChannel& channel, double time) {
  std::array<double, 4> v{};
  SampleChannel(channel, time, v);
  return {v[3], v[0], v[1], v[2]};
}

TEST(Keyframes, StepHoldsTheLastKey) {
  const auto channel =
      Channel(AnimatedPath::kTranslation, Interpolation::kStep, {1, 2, 4}, {1, 0, 0, 5, 0, 0, 9, 0, 0});
  EXPECT_EQ(Scalar(channel, 0), 1);
  EXPECT_EQ(Scalar(channel, 1.999), 1);
  EXPECT_EQ(Scalar(channel, 2), 5);
  EXPECT_EQ(Scalar(channel, 3.999), 5);
  EXPECT_EQ(Scalar(channel, 4), 9);
  EXPECT_EQ(Scalar(channel, 100), 9);
}

TEST(Keyframes, LinearIsClampedAtItsEnds) {
  const auto channel =
      Channel(AnimatedPath::kTranslation, Interpolation::kLinear, {1, 2, 4}, {1, 0, 0, 5, 0, 0, 9, 0, 0});
  EXPECT_EQ(Scalar(channel, -3), 1);
  EXPECT_EQ(Scalar(channel, 1.25), 2);
  EXPECT_EQ(Scalar(channel, 2), 5);
  EXPECT_EQ(Scalar(channel, 3), 7);
  EXPECT_EQ(Scalar(channel, 4.5), 9);
}

TEST(Keyframes, CubicSplineScalesItsTangentsByTheInterval) {
  // Keys (in, value, out) at 1 s and 3 s. By hand at u = 1/2, h = 2:
  // v0 / 2 + h out0 / 8 + v1 / 2 - h in1 / 8 = 1/2 + 2 * 3 / 8 + 4/2 - 2 * (-1) / 8 = 3.5.
  const auto channel = Channel(AnimatedPath::kTranslation, Interpolation::kCubicSpline, {1, 3},
                               {9, 0, 0, 1, 0, 0, 3, 0, 0, -1, 0, 0, 4, 0, 0, 9, 0, 0});
  EXPECT_EQ(Scalar(channel, 0), 1);
  EXPECT_EQ(Scalar(channel, 1), 1);
  EXPECT_DOUBLE_EQ(Scalar(channel, 2), 3.5);
  EXPECT_EQ(Scalar(channel, 3), 4);
  EXPECT_EQ(Scalar(channel, 5), 4);
  // The tangents are derivatives per second.
  EXPECT_NEAR((Scalar(channel, 1 + 1e-6) - Scalar(channel, 1)) / 1e-6, 3, 1e-4);
  EXPECT_NEAR((Scalar(channel, 3) - Scalar(channel, 3 - 1e-6)) / 1e-6, -1, 1e-4);
}

TEST(Keyframes, CubicSplineReproducesACubic) {
  // p(t) = t³ - 2t² + 3t - 1 through keys at 0.5, 1 and 3 with its true derivatives is p everywhere.
  const auto p = [](double t) { return ((t - 2) * t + 3) * t - 1; };
  const auto d = [](double t) { return (3 * t - 4) * t + 3; };
  std::vector<float> values;
  for (const double t : {0.5, 1.0, 3.0}) {
    for (const double v : {d(t), p(t), d(t)}) values.insert(values.end(), {float(v), 0.f, 0.f});
  }
  const auto channel = Channel(AnimatedPath::kTranslation, Interpolation::kCubicSpline, {0.5f, 1, 3}, values);
  for (double t = 0.5; t <= 3; t += 0.01) EXPECT_NEAR(Scalar(channel, t), p(t), 1e-12) << t;
}

TEST(Keyframes, LinearRotationTurnsAtConstantSpeed) {
  // 90 degrees about y: at u the angle is u * 90 degrees.
  const auto h = float(std::sqrt(0.5));
  const auto channel =
      Channel(AnimatedPath::kRotation, Interpolation::kLinear, {0, 2}, {0, 0, 0, 1, 0, h, 0, h});
  for (double t = 0; t <= 2; t += 0.125) {
    const Quatd q = Rotation(channel, t);
    EXPECT_NEAR(2 * std::atan2(q.v.y, q.r), t / 2 * std::acos(0.0), 1e-7);
    EXPECT_NEAR(q.length(), 1, 1e-15);
  }
}

TEST(Keyframes, LinearRotationTakesTheShorterArc) {
  // The second key is the negated quaternion of 90 degrees: the same rotation.
  const auto h = float(std::sqrt(0.5));
  const auto channel =
      Channel(AnimatedPath::kRotation, Interpolation::kLinear, {0, 1}, {0, 0, 0, 1, 0, -h, 0, -h});
  const V3d turned = V3d(1, 0, 0) * Rotation(channel, 0.5).toMatrix44();
  EXPECT_NEAR(turned.x, std::cos(std::acos(0.0) / 2), 1e-7);
  EXPECT_NEAR(turned.z, -std::sin(std::acos(0.0) / 2), 1e-7);
}

TEST(Keyframes, CubicRotationIsNormalised) {
  const auto channel = Channel(AnimatedPath::kRotation, Interpolation::kCubicSpline, {0, 1},
                               {0, 0, 0, 0, 0, 0, 0, 1, 3, 1, 0, 0,  //
                                0, 2, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0});
  for (double t = 0; t <= 1; t += 0.05) {
    EXPECT_NEAR(Rotation(channel, t).length(), 1, 1e-14) << t;
  }
  // By hand at u = 1/2, h = 1: (3/8, 1/8 + 1/2 - 2/8, 0, 1/2 - 1/8), normalised.
  const Quatd q = Rotation(channel, 0.5);
  const double length = std::sqrt(3 * 0.375 * 0.375);
  EXPECT_NEAR(q.v.x, 0.375 / length, 1e-14);
  EXPECT_NEAR(q.v.y, 0.375 / length, 1e-14);
  EXPECT_NEAR(q.r, 0.375 / length, 1e-14);
}

TEST(Keyframes, WeightsOfManyTargets) {
  const auto channel = Channel(AnimatedPath::kWeights, Interpolation::kCubicSpline, {0, 1},
                               {0, 0, 1, 2, 0, 0, 0, 0, 3, 6, 0, 0});
  std::array<double, 2> value{};
  SampleChannel(channel, 0.5, value);
  EXPECT_DOUBLE_EQ(value[0], 2);
  EXPECT_DOUBLE_EQ(value[1], 4);
}

TEST(Keyframes, KeysComeOutExactly) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(-5, 5);
  std::vector<float> times, values;
  float time = -2;
  for (int key = 0; key < 100; ++key) {
    times.push_back(time += 0.01f + std::abs(uniform(random)));
    for (int i = 0; i < 9; ++i) values.push_back(uniform(random));
  }
  const auto cubic = Channel(AnimatedPath::kScale, Interpolation::kCubicSpline, times, values);
  for (size_t key = 0; key < times.size(); ++key) EXPECT_EQ(Scalar(cubic, times[key]), values[key * 9 + 3]);
}

}  // namespace
}  // namespace shutterline::engine::keyframes_test
