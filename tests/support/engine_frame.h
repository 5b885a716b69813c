#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/image/image.h"
#include "common/job/render_settings.h"
#include "common/job/tile.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/scene.h"

/// Whole frames by the engine alone, without service: for tests and benchmarks.
namespace shutterline::engine {

/// A scene from a file, or generated where `name` is one of `shutterline-scenes`' ("plane", ...).
absl::StatusOr<std::shared_ptr<const Scene>> LoadTestScene(const std::string& name);

/// The same scene with unlit flat colours: no textures, no vertex colours, a fixed colour a material.
/// What differs between two pictures of it is visibility alone.
std::shared_ptr<const Scene> WithFlatColors(const Scene& scene);

struct FrameTimes {
  double scene_seconds = 0;   ///< Pose and projection.
  double build_seconds = 0;   ///< Hierarchy.
  double render_seconds = 0;  ///< All tiles, wall time.
};

struct RenderedFrame {
  Image image;
  RenderStats stats;
  FrameTimes times;
  std::vector<std::string> warnings;
};

struct FrameOptions {
  int threads = 1;
  int tile_size = kTileSize;
  std::optional<TileRect> window = std::nullopt;  ///< Only this part of the frame; the picture has its size.
};

/// Renders `frame`, or a window of it.
absl::StatusOr<RenderedFrame> RenderFrame(std::shared_ptr<const Scene> scene, int frame,
                                          const RenderSettings& settings, const FrameOptions& options = {});

/// Masks for errors in motion, a byte a pixel.
struct MovingMasks {
  /// Sees, at some instant, a surface that moves by at least `least_pixels` over the shutter.
  std::vector<uint8_t> region;
  /// Of these, the pixels whose value motion changes: still at shutter open, still at shutter close and
  /// blurred picture differ. Where a surface slides along its own silhouette (a wheel that turns), these
  /// are static edges, and their error is that of the lines.
  std::vector<uint8_t> changed;
};

absl::StatusOr<MovingMasks> MaskMotion(std::shared_ptr<const Scene> scene, int frame,
                                       const RenderSettings& settings, const FrameOptions& options,
                                       double least_pixels = 1);

}  // namespace shutterline::engine
