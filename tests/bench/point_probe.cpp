#include "tests/bench/point_probe.h"

#include <algorithm>

#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "worker/engine/reference/ray_packet.h"
#include "worker/engine/shading/footprint.h"

namespace shutterline::bench {

absl::StatusOr<std::unique_ptr<PointProbe>> PointProbe::Create(
    std::shared_ptr<const engine::FrameScene> frame_scene, const RenderSettings& settings, int threads) {
  SL_ASSIGN_OR_RETURN(engine::Shader shader, engine::Shader::Create(frame_scene, settings));
  SL_ASSIGN_OR_RETURN(engine::EmbreeFrame embree, engine::EmbreeFrame::Build(*frame_scene, threads));
  return std::unique_ptr<PointProbe>(
      new PointProbe(std::move(frame_scene), std::move(shader), std::move(embree)));
}

template <int kWidth>
void PointProbe::SeePackets(std::span<const ProbePoint> points, std::span<ProbeHit> hits) const {
  const engine::CameraRays camera(frame_scene_->view, embree_.scale());
  for (size_t first = 0; first < points.size(); first += kWidth) {
    const size_t count = std::min(size_t(kWidth), points.size() - first);
    typename engine::EmbreePacket<kWidth>::RayHit packet;
    alignas(64) int valid[kWidth];
    for (size_t lane = 0; lane < kWidth; ++lane) {
      valid[lane] = lane < count ? -1 : 0;
      const ProbePoint& p = points[first + std::min(lane, count - 1)];
      camera.Set(packet, int(lane), p.x, p.y, p.t);
    }
    engine::NearestHits nearest;
    engine::IntersectCoherent(valid, embree_.scene(), nearest.context, packet);
    for (size_t lane = 0; lane < count; ++lane) {
      ProbeHit& hit = hits[first + lane];
      const unsigned geometry = packet.hit.geomID[lane];
      hit = {};
      if (geometry == RTC_INVALID_GEOMETRY_ID) continue;
      hit.hit = true;
      hit.triangle = frame_scene_->primitives[geometry].first_triangle + packet.hit.primID[lane];
      // Embree's coordinates may leave the triangle by a rounding.
      hit.b1 = std::clamp(double(packet.hit.u[lane]), 0.0, 1.0);
      hit.b2 = std::clamp(double(packet.hit.v[lane]), 0.0, 1.0 - hit.b1);
    }
  }
}

void PointProbe::See(std::span<const ProbePoint> points, std::span<ProbeHit> hits) const {
  SL_CHECK(points.size() == hits.size());
  switch (embree_.packet_width()) {
    case 16:
      return SeePackets<16>(points, hits);
    case 8:
      return SeePackets<8>(points, hits);
    default:
      return SeePackets<4>(points, hits);
  }
}

RasterPoint PointProbe::At(const ProbeHit& hit, double t) const {
  const engine::FrameTriangle& triangle = frame_scene_->triangles[hit.triangle];
  const engine::FramePrimitive& primitive = frame_scene_->primitives[triangle.primitive];
  const auto vertex = [&](int i) {
    return frame_scene_->VertexAt(primitive, triangle.vertices[size_t(i)], t);
  };
  return (1 - hit.b1 - hit.b2) * vertex(0) + hit.b1 * vertex(1) + hit.b2 * vertex(2);
}

V3f PointProbe::Radiance(const ProbeHit& hit, double t) const {
  if (!hit.hit) return V3f(0);
  const engine::FrameTriangle& triangle = frame_scene_->triangles[hit.triangle];
  const engine::FramePrimitive& primitive = frame_scene_->primitives[triangle.primitive];
  const engine::Barycentric at{hit.b1, hit.b2};
  if (shader_.IsConstant(primitive)) {
    return shader_.Shade(hit.triangle, at, engine::Footprint{});
  }
  std::array<RasterPoint, 3> vertices;
  for (int i = 0; i < 3; ++i) {
    vertices[i] = frame_scene_->VertexAt(primitive, triangle.vertices[size_t(i)], t);
  }
  return shader_.Shade(hit.triangle, at, engine::PixelFootprint(vertices, at));
}

double PointProbe::Distance(const ProbeHit& hit, double t) const {
  return -frame_scene_->view.ViewFromRaster(At(hit, t)).z;
}

V2d PointProbe::Motion(const ProbeHit& hit) const {
  const RasterPoint open = At(hit, 0), close = At(hit, 1);
  return V2d(close.x / close.w - open.x / open.w, close.y / close.w - open.y / open.w);
}

}  // namespace shutterline::bench
