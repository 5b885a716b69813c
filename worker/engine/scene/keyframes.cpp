#include "worker/engine/scene/keyframes.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace shutterline::engine {
namespace {

Quatd QuaternionAt(const float* xyzw) {
  return UnitQuaternion(xyzw[0], xyzw[1], xyzw[2], xyzw[3]);
}

void Store(const Quatd& q, std::span<double> value) {
  value[0] = q.v.x;
  value[1] = q.v.y;
  value[2] = q.v.z;
  value[3] = q.r;
}

/// Cubic Hermite spline between two keys; `duration` scales the tangents, which are per second.
double Hermite(double v0, double out0, double in1, double v1, double duration, double u) {
  const double u2 = u * u, u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * v0 + duration * (u3 - 2 * u2 + u) * out0 + (-2 * u3 + 3 * u2) * v1 +
         duration * (u3 - u2) * in1;
}

}  // namespace

Quatd UnitQuaternion(double x, double y, double z, double w) {
  const double length = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(length > 0) || !std::isfinite(length)) return {};
  return {w / length, x / length, y / length, z / length};
}

void SampleChannel(const AnimationChannel& channel, double time, std::span<double> value) {
  const size_t width = size_t(channel.width);
  SL_CHECK(value.size() >= width && !channel.times.empty());
  const bool cubic = channel.interpolation == Interpolation::kCubicSpline;
  const bool rotation = channel.path == AnimatedPath::kRotation;
  const size_t stride = cubic ? 3 * width : width;
  const auto key_value = [&](size_t key) { return &channel.values[key * stride + (cubic ? width : 0)]; };

  // Find the last key that is not after `time`.
  const auto after = std::upper_bound(channel.times.begin(), channel.times.end(), time);
  const size_t next = size_t(after - channel.times.begin());
  const size_t key = next == 0 ? 0 : next - 1;
  const double start = channel.times[key];
  const bool on_key = next == 0 || next == channel.times.size() || time == start;

  if (on_key || channel.interpolation == Interpolation::kStep) {
    for (size_t i = 0; i < width; ++i) value[i] = key_value(key)[i];
    if (rotation) Store(QuaternionAt(key_value(key)), value);
    return;
  }
  const double duration = double(channel.times[next]) - start;
  const double u = (time - start) / duration;
  const float* v0 = key_value(key);
  const float* v1 = key_value(next);
  if (cubic) {
    const float* out0 = v0 + width;
    const float* in1 = v1 - width;
    for (size_t i = 0; i < width; ++i) value[i] = Hermite(v0[i], out0[i], in1[i], v1[i], duration, u);
    if (rotation) Store(UnitQuaternion(value[0], value[1], value[2], value[3]), value);
  } else if (rotation) {
    const Quatd q = Imath::slerpShortestArc(QuaternionAt(v0), QuaternionAt(v1), u);
    Store(UnitQuaternion(q.v.x, q.v.y, q.v.z, q.r), value);
  } else {
    for (size_t i = 0; i < width; ++i) value[i] = (1 - u) * double(v0[i]) + u * double(v1[i]);
  }
}

}  // namespace shutterline::engine
