#include "tests/scenes/keys.h"

#include <ImathMatrixAlgo.h>

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace shutterline::scenes {
namespace {

constexpr int kLegFrames = 2;
static_assert(kLegFrames / (kShutterSeconds * kFrameRate) == kLegShutters);

float LegTime(int leg) {
  return float(leg * kLegFrames / kFrameRate);
}

}  // namespace

double PixelsPerMetre(double yfov, double depth) {
  return kFrameHeight / 2 / std::tan(yfov / 2) / depth;
}

Channel SwingTranslation(int node, const V3f& centre, const V3f& per_shutter) {
  Channel channel{node, Path::kTranslation, {}, {}};
  for (int leg = 0; leg * kLegFrames <= kAnimatedFrames; ++leg) {
    const float side = leg % 2 == 0 ? -1.0f : 1.0f;
    const V3f place = centre + per_shutter * (side * float(kLegShutters) / 2);
    channel.times.push_back(LegTime(leg));
    channel.values.insert(channel.values.end(), {place.x, place.y, place.z});
  }
  return channel;
}

Channel SwingWeight(int node) {
  Channel channel{node, Path::kWeights, {}, {}};
  for (int leg = 0; leg * kLegFrames <= kAnimatedFrames; ++leg) {
    channel.times.push_back(LegTime(leg));
    channel.values.push_back(leg % 2 == 0 ? 0.0f : 1.0f);
  }
  return channel;
}

Channel SwingRotation(int node, const V3f& axis, double degrees_per_shutter, const Imath::Quatf& base) {
  SL_CHECK(std::abs(degrees_per_shutter) * kLegShutters < 180);
  Channel channel{node, Path::kRotation, {}, {}};
  for (int leg = 0; leg * kLegFrames <= kAnimatedFrames; ++leg) {
    const double side = leg % 2 == 0 ? -1 : 1;
    const Imath::Quatf turn = Turn(axis, degrees_per_shutter * side * kLegShutters / 2) * base;
    channel.times.push_back(LegTime(leg));
    channel.values.insert(channel.values.end(), {turn.v.x, turn.v.y, turn.v.z, turn.r});
  }
  return channel;
}

Channel Spin(int node, const V3f& axis, double start_degrees, double degrees_per_shutter) {
  Channel channel{node, Path::kRotation, {}, {}};
  const double seconds = kAnimatedFrames / kFrameRate;
  const double degrees = degrees_per_shutter * seconds / kShutterSeconds;
  const int steps = std::max(1, int(std::ceil(std::abs(degrees) / 45)));
  for (int i = 0; i <= steps; ++i) {
    const Imath::Quatf turn = Turn(axis, start_degrees + degrees * i / steps);
    channel.times.push_back(float(seconds * i / steps));
    channel.values.insert(channel.values.end(), {turn.v.x, turn.v.y, turn.v.z, turn.r});
  }
  return channel;
}

Node CameraNode(GlbScene& scene, const Camera& camera, const V3f& eye, const V3f& target) {
  // glTF's cameras look along −z with y up; the rows are where the axes go.
  const V3f z = (eye - target).normalized();
  const V3f x = V3f(0, 1, 0).cross(z).normalized();
  const V3f y = z.cross(x);
  const Imath::M44f rows(x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, 0, 0, 0, 1);
  Node node;
  node.name = "camera";
  node.translation = eye;
  node.rotation = Imath::extractQuat(rows).normalized();
  node.camera = scene.Add(camera);
  return node;
}

Imath::Quatf Turn(const V3f& axis, double degrees) {
  const double half = degrees * M_PI / 360;
  const double s = std::sin(half);
  return Imath::Quatf(float(std::cos(half)), float(s * axis.x), float(s * axis.y), float(s * axis.z));
}

}  // namespace shutterline::scenes
