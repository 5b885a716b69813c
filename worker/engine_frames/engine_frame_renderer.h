#pragma once

#include <memory>
#include <utility>

#include "worker/engine/shading/shading_cache.h"
#include "worker/frames/frame_renderer.h"

namespace shutterline::worker {

/// Production: glTF import, frame scene and tile integrator of worker/engine. Exceptions of libraries end
/// here as statuses, running out of memory included.
class EngineFrameRendererFactory final : public FrameRendererFactory {
 public:
  /// `cache` is for all frames; null: nothing is kept.
  explicit EngineFrameRendererFactory(std::shared_ptr<engine::ShadingCache> cache)
      : cache_(std::move(cache)) {}

  absl::StatusOr<std::shared_ptr<const engine::Scene>> Import(const engine::AssetSource& source) override;
  absl::StatusOr<std::shared_ptr<const FrameRenderer>> MakeFrame(std::shared_ptr<const engine::Scene> scene,
                                                                 int frame, const RenderSettings& settings,
                                                                 int threads) override;

 private:
  const std::shared_ptr<engine::ShadingCache> cache_;
};

}  // namespace shutterline::worker
