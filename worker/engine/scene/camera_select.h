#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// A camera of the file and the node that places it, or neither: the automatic camera.
struct CameraChoice {
  int camera = -1;
  int node = -1;
  bool IsAutomatic() const { return node < 0; }
};

/// The camera that `name` means: a camera's name, else the name of a node that has a camera, else a
/// camera's index in decimal digits. Where several nodes of the default scene place that camera, the first
/// in node order (parents before children, siblings as in the file) counts. Empty: the first camera node
/// of the default scene, or the automatic camera where there is none. INVALID_ARGUMENT, listing the
/// cameras that there are, where nothing matches or no node of the default scene places the camera, and
/// where the camera's own numbers make no picture (see MakeFrameView).
absl::StatusOr<CameraChoice> SelectCamera(const Scene& scene, absl::string_view name);

/// The frame's projection. Perspective: `yfov` is the vertical field of view of the *frame*, whatever the
/// camera's aspect ratio; the horizontal one follows from the frame's shape, so pixels are square.
/// Orthographic: the whole box of 2 xmag by 2 ymag metres is in the picture, centred, as large as fits with
/// square pixels. INVALID_ARGUMENT naming the number unless 0 < yfov < π and 0 < znear (perspective), 0 <
/// xmag, ymag and 0 <= znear (orthographic), and znear < zfar (or, for perspective, zfar = 0: infinite).
absl::StatusOr<FrameView> MakeFrameView(const Camera& camera, int width, int height);

}  // namespace shutterline::engine
