#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "worker/engine/accel/embree_frame.h"
#include "worker/engine/reference/hit_shader.h"
#include "worker/engine/reference/ray_packet.h"

namespace shutterline::engine {

/// Traces a packet's rays through layers down to what is opaque, and adds what they see, premultiplied, to
/// `sums`: red, green, blue and coverage. `wanted`: the lanes that count; `times`: shutter time by lane. A
/// layer exactly where another surface is hides it.
template <int kWidth>
void WalkRays(const HitShader& shader, RTCScene scene, const int* wanted,
              const std::array<double, kWidth>& times, typename EmbreePacket<kWidth>::RayHit& packet,
              std::array<std::array<double, 4>, kWidth>& sums, RenderStats& stats) {
  constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  /// What less light than this passes is opaque.
  constexpr double kLeastLight = 1e-6;
  alignas(64) int valid[kWidth];
  std::array<float, kWidth> far;
  std::array<double, kWidth> light;
  std::array<uint32_t, kWidth> last;
  std::copy_n(wanted, kWidth, valid);
  std::copy_n(packet.ray.tfar, kWidth, far.begin());
  light.fill(1);
  last.fill(kNone);
  for (bool goes_on = true; goes_on;) {
    goes_on = false;
    NearestHits nearest;
    IntersectCoherent(valid, scene, nearest.context, packet);
    for (size_t lane = 0; lane < kWidth; ++lane) {
      if (valid[lane] == 0) continue;
      valid[lane] = 0;
      const unsigned geometry = packet.hit.geomID[lane];
      if (geometry == RTC_INVALID_GEOMETRY_ID) continue;
      const uint32_t triangle = shader.frame().primitives[geometry].first_triangle + packet.hit.primID[lane];
      const double b1 = double(packet.hit.u[lane]), b2 = double(packet.hit.v[lane]);
      // Rounding may let a ray meet again what it has just passed.
      if (triangle != last[lane]) {
        const double alpha = shader.Alpha(triangle, b1, b2, times[lane]);
        if (alpha > 0) {
          const V3f radiance = shader.Radiance(triangle, b1, b2, times[lane], stats);
          const double share = light[lane] * alpha;
          for (size_t c = 0; c < 3; ++c) sums[lane][c] += share * double(radiance[int(c)]);
          sums[lane][3] += share;
          light[lane] *= 1 - alpha;
        }
        last[lane] = triangle;
      }
      if (light[lane] < kLeastLight) continue;
      packet.ray.tnear[lane] = std::nextafter(packet.ray.tfar[lane], std::numeric_limits<float>::infinity());
      packet.ray.tfar[lane] = far[lane];
      packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      valid[lane] = -1;
      goes_on = true;
    }
  }
}

}  // namespace shutterline::engine
