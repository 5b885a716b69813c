#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/engine/accel/embree.h"
#include "worker/engine/accel/embree_frame.h"

namespace shutterline::engine {

template <int kWidth>
struct EmbreePacket;
template <>
struct EmbreePacket<4> {
  using RayHit = RTCRayHit4;
};
template <>
struct EmbreePacket<8> {
  using RayHit = RTCRayHit8;
};
template <>
struct EmbreePacket<16> {
  using RayHit = RTCRayHit16;
};

/// Makes the rays of a camera in EmbreeFrame's coordinates: distance along a ray is distance along the view
/// direction.
class CameraRays {
 public:
  CameraRays(const FrameView& view, double scale) : view_(view), scale_(scale) {
    if (view.perspective) {
      near_ = view.znear / scale;
      far_ = view.zfar > 0 ? view.zfar / scale : std::numeric_limits<double>::infinity();
    } else {
      // Rays may only begin at positive distances: where the near plane is at the eye or behind it, they
      // start one depth of the view in front of that plane.
      start_ = view.znear > 0 ? 0 : 2 * view.znear - view.zfar;
      near_ = (view.znear - start_) / scale;
      far_ = (view.zfar - start_) / scale;
    }
  }

  /// Ray `lane` of a packet, through (x, y) of raster space at shutter time t.
  template <typename RayHit>
  void Set(RayHit& packet, int lane, double x, double y, double t) const {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    auto& ray = packet.ray;
    const double view_x = (x - view_.center_x) / view_.scale_x;
    const double view_y = (view_.center_y - y) / view_.scale_y;
    ray.org_x[lane] = view_.perspective ? 0 : float(view_x / scale_);
    ray.org_y[lane] = view_.perspective ? 0 : float(view_y / scale_);
    ray.org_z[lane] = float(-start_ / scale_);
    ray.dir_x[lane] = view_.perspective ? float(view_x) : 0;
    ray.dir_y[lane] = view_.perspective ? float(view_y) : 0;
    ray.dir_z[lane] = -1;
    // Both planes belong to what is visible; Embree's interval does not hold its lower end.
    ray.tnear[lane] = std::max(0.0f, std::nextafter(float(near_), -kInfinity));
    ray.tfar[lane] = std::nextafter(float(far_), kInfinity);
    ray.time[lane] = float(t);
    ray.mask[lane] = ~0u;
    ray.id[lane] = unsigned(lane);
    ray.flags[lane] = 0;
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }

 private:
  const FrameView& view_;
  double scale_;
  double start_ = 0;       ///< Where rays start along the view direction, metres.
  double near_ = 0, far_;  ///< Along the ray, scaled.
};

}  // namespace shutterline::engine
