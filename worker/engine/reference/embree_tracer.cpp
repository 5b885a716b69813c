#include "worker/engine/reference/embree_tracer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "worker/engine/reference/ray_packet.h"
#include "worker/engine/reference/ray_walk.h"

namespace shutterline::engine {

absl::StatusOr<std::unique_ptr<EmbreeTracer>> EmbreeTracer::Create(
    std::shared_ptr<const FrameScene> frame_scene, int frame, const RenderSettings& settings, int threads,
    std::shared_ptr<ShadingCache> cache) {
  SL_ASSIGN_OR_RETURN(EmbreeFrame embree, EmbreeFrame::Build(*frame_scene, threads));
  SL_ASSIGN_OR_RETURN(Shader shader, Shader::Create(frame_scene, settings, threads));
  return std::unique_ptr<EmbreeTracer>(new EmbreeTracer(
      std::move(frame_scene), std::move(shader), std::move(embree), std::move(cache), frame, settings));
}

EmbreeTracer::EmbreeTracer(std::shared_ptr<const FrameScene> frame_scene, Shader shader, EmbreeFrame embree,
                           std::shared_ptr<ShadingCache> cache, int frame, const RenderSettings& settings)
    : frame_scene_(std::move(frame_scene)),
      embree_(std::move(embree)),
      shader_(std::move(shader), settings, std::move(cache)),
      pattern_(settings.seed, frame),
      filter_(settings),
      shutter_(settings.shutter_curve),
      spp_(settings.spp) {
  SL_CHECK(spp_ >= 1);
}

template <int kWidth>
void EmbreeTracer::RenderPixels(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const {
  const CameraRays camera(frame_scene_->view, embree_.scale());
  const auto start = std::chrono::steady_clock::now();
  float* out = rgba.data();
  for (int y = rect.y; y < rect.y + rect.height; ++y) {
    for (int x = rect.x; x < rect.x + rect.width; ++x) {
      const PixelPoints points = pattern_.Pixel(x, y);
      std::array<double, 4> sum{};
      // A packet holds rays of one pixel only, so that no ray has other company in another tile.
      for (int first = 0; first < spp_; first += kWidth) {
        const int count = std::min(kWidth, spp_ - first);
        typename EmbreePacket<kWidth>::RayHit packet;
        alignas(64) int valid[kWidth];
        for (int lane = 0; lane < kWidth; ++lane) {
          valid[lane] = lane < count ? -1 : 0;
          const PixelPoint p = filter_.Place(points.At(uint32_t(first + std::min(lane, count - 1))));
          camera.Set(packet, lane, x + p.x, y + p.y, shutter_.TimeOf(p.t));
        }
        std::array<double, kWidth> times;
        std::copy_n(packet.ray.time, kWidth, times.begin());
        std::array<std::array<double, 4>, kWidth> seen{};
        WalkRays<kWidth>(shader_, embree_.scene(), valid, times, packet, seen, stats);
        for (const std::array<double, 4>& lane : seen) {
          for (size_t c = 0; c < 4; ++c) sum[c] += lane[c];
        }
      }
      for (const double channel : sum) *out++ = float(channel / spp_);
    }
  }
  // Shading is part of it: timing single packets would cost more than it tells.
  stats.resolve_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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
