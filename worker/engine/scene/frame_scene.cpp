#include "worker/engine/scene/frame_scene.h"

#include <absl/strings/str_cat.h>

#include <new>
#include <stdexcept>
#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/scene/animation_select.h"
#include "worker/engine/scene/camera_select.h"
#include "worker/engine/scene/frame_builder.h"

namespace shutterline::engine {

absl::Status ValidateAgainstScene(const Scene& scene, const RenderSettings& settings) {
  SL_RETURN_IF_ERROR(SelectChannels(scene, settings.animation).status());
  return SelectCamera(scene, settings.camera).status();
}

absl::StatusOr<std::shared_ptr<const FrameScene>> BuildFrameScene(std::shared_ptr<const Scene> scene,
                                                                  int frame, const RenderSettings& settings) {
  SL_RETURN_IF_ERROR(Validate(settings));
  SL_ASSIGN_OR_RETURN(std::vector<const AnimationChannel*> channels,
                      SelectChannels(*scene, settings.animation));
  SL_ASSIGN_OR_RETURN(const CameraChoice choice, SelectCamera(*scene, settings.camera));
  const std::string name = scene->name;
  try {
    FrameBuilder builder(std::move(scene), std::move(channels), choice, frame, settings);
    SL_RETURN_IF_ERROR(builder.Build());
    return builder.Take();
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(
        absl::StrCat("scene ", name, ": not enough memory for frame ", frame));
  } catch (const std::length_error&) {
    return absl::ResourceExhaustedError(absl::StrCat("scene ", name, ": frame ", frame, " is too large"));
  }
}

}  // namespace shutterline::engine
