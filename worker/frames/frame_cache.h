#pragma once

#include <absl/status/statusor.h>
#include <absl/time/time.h>

#include <cstddef>
#include <memory>

#include "common/asset/digest.h"
#include "common/base/clock.h"
#include "common/job/render_settings.h"
#include "worker/engine/scene/asset_source.h"
#include "worker/engine/scene/scene_shelf.h"
#include "worker/frames/frame_renderer.h"
#include "worker/frames/single_flight_cache.h"

namespace shutterline::worker {

struct FrameCacheOptions {
  size_t max_scenes = 2;
  size_t max_frames = 4;
  int build_threads = 1;  ///< For import and frame set-up.
  /// How long the error of what took too long (DEADLINE_EXCEEDED) is kept before it is tried again: as long
  /// as it may take, so that no scene has more than half of a thread's time. Infinite: for as long as it is
  /// remembered.
  absl::Duration retry_late = absl::InfiniteDuration();
  engine::SceneShelf* shelf =
      nullptr;  ///< Where a scene may lie that is imported already. Outlives the cache.
};

/// Where a scene's files are read from, should it have to be imported.
using AssetSourceMaker = std::function<absl::StatusOr<std::unique_ptr<engine::AssetSource>>()>;

/// Scenes, each imported once, and frames made ready, each once: what all tiles of a frame share. Bounded
/// by count; what threads still use lives on until they let go of it. Thread-safe.
class FrameCache {
 public:
  /// `factory` and `clock` must outlive this.
  FrameCache(FrameRendererFactory& factory, const FrameCacheOptions& options,
             const Clock& clock = Clock::System());

  /// Frame `frame` of the scene whose manifest has digest `scene`. Blocks while it is imported and made
  /// ready, by this thread or another. Errors name what failed ("frame 3: …").
  absl::StatusOr<std::shared_ptr<const FrameRenderer>> Get(const Digest& scene, int frame,
                                                           const RenderSettings& settings,
                                                           const AssetSourceMaker& open_source);

  size_t scene_count() const { return scenes_.size(); }
  size_t frame_count() const { return frames_.size(); }

 private:
  struct FrameKey {
    Digest scene;
    int frame;
    RenderSettings settings;
    friend bool operator==(const FrameKey&, const FrameKey&) = default;
  };

  absl::Duration KeepTimeOf(const absl::Status& error) const;

  FrameRendererFactory& factory_;
  const FrameCacheOptions options_;
  SingleFlightCache<Digest, engine::Scene> scenes_;
  SingleFlightCache<FrameKey, FrameRenderer> frames_;
};

}  // namespace shutterline::worker
