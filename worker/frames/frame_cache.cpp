#include "worker/frames/frame_cache.h"

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace shutterline::worker {
namespace {

/// Errors that lie in the scene or the settings: the same input meets them again. A coordinator that
/// cannot be reached, a lost blob or a full disk may be better next time.
bool IsPermanent(const absl::Status& status) {
  return absl::IsInvalidArgument(status) || absl::IsUnimplemented(status) || absl::IsOutOfRange(status);
}

}  // namespace

FrameCache::FrameCache(FrameRendererFactory& factory, const FrameCacheOptions& options, const Clock& clock)
    : factory_(factory),
      options_(options),
      scenes_(
          options.max_scenes, [this](const absl::Status& error) { return KeepTimeOf(error); }, clock),
      frames_(
          options.max_frames, [this](const absl::Status& error) { return KeepTimeOf(error); }, clock) {}

absl::Duration FrameCache::KeepTimeOf(const absl::Status& error) const {
  if (IsPermanent(error)) return absl::InfiniteDuration();
  return absl::IsDeadlineExceeded(error) ? options_.retry_late : absl::ZeroDuration();
}

absl::StatusOr<std::shared_ptr<const FrameRenderer>> FrameCache::Get(const Digest& scene, int frame,
                                                                     const RenderSettings& settings,
                                                                     const AssetSourceMaker& open_source) {
  const auto import = [&]() -> absl::StatusOr<std::shared_ptr<const engine::Scene>> {
    if (options_.shelf != nullptr) {
      if (auto shelved = options_.shelf->Take(scene)) return shelved;
    }
    SL_ASSIGN_OR_RETURN(const std::unique_ptr<engine::AssetSource> source, open_source());
    return factory_.Import(*source);
  };
  const auto make = [&]() -> absl::StatusOr<std::shared_ptr<const FrameRenderer>> {
    SL_ASSIGN_OR_RETURN(std::shared_ptr<const engine::Scene> imported, scenes_.Get(scene, import));
    auto made = factory_.MakeFrame(std::move(imported), frame, settings, options_.build_threads);
    if (!made.ok()) return Annotate(made.status(), absl::StrCat("frame ", frame));
    return made;
  };
  return frames_.Get({scene, frame, settings}, make);
}

}  // namespace shutterline::worker
