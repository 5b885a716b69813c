#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/image/image.h"
#include "common/job/render_settings.h"
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

/// Renders `frame` in tiles of `tile_size` pixels with `threads` threads.
absl::StatusOr<RenderedFrame> RenderFrame(std::shared_ptr<const Scene> scene, int frame,
                                          const RenderSettings& settings, int threads,
                                          int tile_size = kTileSize);

/// One for each pixel that motion changes: where stills at shutter open and close and `blurred` differ.
absl::StatusOr<std::vector<uint8_t>> MovingRegion(std::shared_ptr<const Scene> scene, int frame,
                                                  const RenderSettings& settings, const Image& blurred,
                                                  int threads);

}  // namespace shutterline::engine
