#pragma once

#include <absl/time/time.h>

#include <memory>
#include <utility>

#include "common/base/clock.h"
#include "worker/engine/shading/shading_cache.h"
#include "worker/frames/frame_renderer.h"

namespace shutterline::worker {

/// Production: glTF import, frame scene and tile integrator of worker/engine. Exceptions of libraries end
/// here as statuses, running out of memory included.
class EngineFrameRendererFactory final : public FrameRendererFactory {
 public:
  /// `cache` is for all frames; null: nothing is kept. To import a scene and to make a frame of it ready may
  /// take `time` each, by `clock`, which must outlive this; beyond it they fail, DEADLINE_EXCEEDED.
  explicit EngineFrameRendererFactory(std::shared_ptr<engine::ShadingCache> cache,
                                      absl::Duration time = absl::InfiniteDuration(),
                                      const Clock& clock = Clock::System())
      : cache_(std::move(cache)), time_(time), clock_(clock) {}

  absl::StatusOr<std::shared_ptr<const engine::Scene>> Import(const engine::AssetSource& source) override;
  absl::StatusOr<std::shared_ptr<const FrameRenderer>> MakeFrame(std::shared_ptr<const engine::Scene> scene,
                                                                 int frame, const RenderSettings& settings,
                                                                 int threads) override;

 private:
  const std::shared_ptr<engine::ShadingCache> cache_;
  const absl::Duration time_;
  const Clock& clock_;
};

}  // namespace shutterline::worker
