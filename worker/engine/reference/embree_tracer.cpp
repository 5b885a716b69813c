#include "worker/engine/reference/embree_tracer.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "worker/engine/reference/ray_packet.h"

namespace shutterline::engine {
namespace {

class Stopwatch {
 public:
  double Seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

absl::StatusOr<std::unique_ptr<EmbreeTracer>> EmbreeTracer::Create(
    std::shared_ptr<const FrameScene> frame_scene, int frame, const RenderSettings& settings, int threads) {
  SL_ASSIGN_OR_RETURN(EmbreeFrame embree, EmbreeFrame::Build(*frame_scene, threads));
  return std::unique_ptr<EmbreeTracer>(
      new EmbreeTracer(std::move(frame_scene), std::move(embree), frame, settings));
}

EmbreeTracer::EmbreeTracer(std::shared_ptr<const FrameScene> frame_scene, EmbreeFrame embree, int frame,
                           const RenderSettings& settings)
    : frame_scene_(std::move(frame_scene)),
      embree_(std::move(embree)),
      shader_(frame_scene_, settings),
      pattern_(settings.seed, frame),
      spp_(settings.spp) {
  SL_CHECK(spp_ >= 1);
}

template <int kWidth>
void EmbreeTracer::RenderPixels(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const {
  const CameraRays camera(frame_scene_->view, embree_.scale());
  float* out = rgba.data();
  for (int y = rect.y; y < rect.y + rect.height; ++y) {
    for (int x = rect.x; x < rect.x + rect.width; ++x) {
      const PixelPoints points = pattern_.Pixel(x, y);
      double red = 0, green = 0, blue = 0;
      int covered = 0;
      // A packet holds rays of one pixel only, so that no ray has other company in another tile.
      for (int first = 0; first < spp_; first += kWidth) {
        const int count = std::min(kWidth, spp_ - first);
        typename EmbreePacket<kWidth>::RayHit packet;
        alignas(64) int valid[kWidth];
        for (int lane = 0; lane < kWidth; ++lane) {
          valid[lane] = lane < count ? -1 : 0;
          const PixelPoint p = points.At(uint32_t(first + std::min(lane, count - 1)));
          camera.Set(packet, lane, x + p.x, y + p.y, p.t);
        }
        NearestHits nearest;
        const Stopwatch tracing;
        IntersectCoherent(valid, embree_.scene(), nearest.context, packet);
        stats.resolve_seconds += tracing.Seconds();

        const Stopwatch shading;
        for (int lane = 0; lane < count; ++lane) {
          const unsigned geometry = packet.hit.geomID[lane];
          if (geometry == RTC_INVALID_GEOMETRY_ID) continue;
          const uint32_t triangle =
              frame_scene_->primitives[geometry].first_triangle + packet.hit.primID[lane];
          const V3f radiance =
              shader_.Radiance(triangle, packet.hit.u[lane], packet.hit.v[lane], packet.ray.time[lane]);
          red += radiance.x;
          green += radiance.y;
          blue += radiance.z;
          ++covered;
        }
        stats.shade_seconds += shading.Seconds();
      }
      *out++ = float(red / spp_);
      *out++ = float(green / spp_);
      *out++ = float(blue / spp_);
      *out++ = float(double(covered) / spp_);
    }
  }
  stats.instants += rect.Area() * spp_;
}

void EmbreeTracer::Render(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const {
  SL_CHECK(rgba.size() == 4 * size_t(rect.Area()));
  switch (embree_.packet_width()) {
    case 16:
      RenderPixels<16>(rect, rgba, stats);
      break;
    case 8:
      RenderPixels<8>(rect, rgba, stats);
      break;
    default:
      RenderPixels<4>(rect, rgba, stats);
  }
  ++stats.tiles;
}

}  // namespace shutterline::engine
