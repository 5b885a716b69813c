#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "worker/engine/accel/embree.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// A frame's triangles as an Embree scene: one geometry a primitive, numbered alike, vertices in view space
/// divided by scale(). Where a primitive moves, as many time steps as its straight pieces have ends
/// (FramePrimitive::linear_pieces), which Embree joins by straight lines. Occlusion queries pass through
/// layers, materials that are not opaque. Immutable; any number of threads may trace.
class EmbreeFrame {
 public:
  static absl::StatusOr<EmbreeFrame> Build(const FrameScene& frame, int threads);
  /// The same frozen at shutter time `instant`, without motion; built as fast as can be where `quickly`, for
  /// few rays. On the calling thread and those of its task arena. Many frames may share a device.
  static absl::StatusOr<EmbreeFrame> BuildAt(const FrameScene& frame, double instant, bool quickly,
                                             const EmbreeDevice& device);

  RTCScene scene() const { return scene_.get(); }
  /// Metres a unit of Embree's coordinates, a power of two.
  double scale() const { return scale_; }
  /// Rays that this processor traces at once: 4, 8 or 16.
  int packet_width() const { return packet_width_; }

 private:
  /// What the filter of a geometry needs to know of it.
  struct GeometryInfo {
    uint32_t first_triangle;
    bool double_sided;
  };

  static void FilterHits(const RTCFilterFunctionNArguments* arguments);
  static void LetPass(const RTCFilterFunctionNArguments* arguments);

  static absl::StatusOr<EmbreeFrame> BuildScene(const FrameScene& frame, std::optional<double> instant,
                                                RTCBuildQuality quality, EmbreeDevice device);
  absl::Status AddPrimitive(const FrameScene& frame, unsigned number, std::optional<double> instant);

  // In this order: the scene goes before what its geometries point to, and before its device.
  EmbreeDevice device_;
  std::vector<GeometryInfo> infos_;
  EmbreeScene scene_;
  double scale_ = 1;
  int packet_width_ = 4;
};

/// The context that rays must be traced with: remembers each ray's nearest hit, so that of equally near
/// ones the lowest triangle wins whatever the order in which Embree meets them. A ray's `id` is its index
/// here, below 16. One for each packet.
struct NearestHits {
  EmbreeQueryContext context;  // Embree hands its address to the filter: must come first.
  float distance[16];
  uint32_t triangle[16];

  NearestHits();
};

}  // namespace shutterline::engine
