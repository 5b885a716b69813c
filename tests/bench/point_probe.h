#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/job/render_settings.h"
#include "common/math/spaces.h"
#include "worker/engine/accel/embree_frame.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/shade.h"

namespace shutterline::bench {

/// A point of raster space and the shutter.
struct ProbePoint {
  double x = 0, y = 0, t = 0;
};

struct ProbeHit {
  bool hit = false;
  uint32_t triangle = 0;
  double b1 = 0, b2 = 0;
};

/// What single rays see, by the same rules as the reference integrator: for masks, line-restricted references
/// and figures of single samples. Any number of threads may ask.
class PointProbe {
 public:
  static absl::StatusOr<std::unique_ptr<PointProbe>> Create(
      std::shared_ptr<const engine::FrameScene> frame_scene, const RenderSettings& settings, int threads);

  /// `hits` is as long as `points`; what comes out depends on each point alone.
  void See(std::span<const ProbePoint> points, std::span<ProbeHit> hits) const;

  const engine::FrameScene& frame_scene() const { return *frame_scene_; }
  const engine::Shader& shader() const { return shader_; }
  /// What the reference integrator shades there.
  V3f Radiance(const ProbeHit& hit, double t) const;
  /// Distance along the view direction, metres.
  double Distance(const ProbeHit& hit, double t) const;
  /// How far the point of the triangle moves in the picture over the shutter, pixels.
  V2d Motion(const ProbeHit& hit) const;

 private:
  PointProbe(std::shared_ptr<const engine::FrameScene> frame_scene, engine::Shader shader,
             engine::EmbreeFrame embree)
      : frame_scene_(std::move(frame_scene)), shader_(std::move(shader)), embree_(std::move(embree)) {}

  template <int kWidth>
  void SeePackets(std::span<const ProbePoint> points, std::span<ProbeHit> hits) const;
  /// A triangle's point at shutter time t.
  RasterPoint At(const ProbeHit& hit, double t) const;

  std::shared_ptr<const engine::FrameScene> frame_scene_;
  engine::Shader shader_;
  engine::EmbreeFrame embree_;
};

}  // namespace shutterline::bench
