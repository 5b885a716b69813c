#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <span>

#include "common/job/render_settings.h"
#include "common/job/tile.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/scene/asset_source.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::worker {

/// A frame that is ready to be rendered, tile by tile.
class FrameRenderer {
 public:
  virtual ~FrameRenderer() = default;

  /// Renders `rect` into OutputChannelCount(settings) * rect.Area() floats, rows from the top, the first four
  /// of a pixel linear premultiplied RGBA. Adds to `stats`. Thread-safe, and what is written depends on the
  /// frame, the settings and `rect` alone.
  virtual absl::Status Render(const TileRect& rect, std::span<float> pixels,
                              engine::RenderStats& stats) const = 0;
};

/// The engine as the worker sees it. Tests put slow, failing and scripted ones in its place. Thread-safe.
class FrameRendererFactory {
 public:
  virtual ~FrameRendererFactory() = default;

  virtual absl::StatusOr<std::shared_ptr<const engine::Scene>> Import(const engine::AssetSource& source) = 0;

  /// Makes frame `frame` of `scene` ready, using up to `threads` threads.
  virtual absl::StatusOr<std::shared_ptr<const FrameRenderer>> MakeFrame(
      std::shared_ptr<const engine::Scene> scene, int frame, const RenderSettings& settings, int threads) = 0;
};

}  // namespace shutterline::worker
