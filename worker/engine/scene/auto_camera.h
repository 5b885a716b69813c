#pragma once

#include "common/math/spaces.h"
#include "worker/engine/scene/camera_pose.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

struct AutoCamera {
  Camera camera;
  CameraPose pose;
};

/// The camera of a scene that has none: a perspective one that looks down at the centre of `bounds` from
/// the front right, so near that the box fills the frame but for a margin of a tenth. Its near plane is a
/// hundredth of the way to the centre, its far plane infinite, so everything scales with the scene. Given
/// the bounds of the whole animation it stands still in every frame; the shape of the frame (`width` by
/// `height`) decides only how far away it stands. An empty box counts as the unit box.
AutoCamera MakeAutoCamera(const Box3d& bounds, int width, int height);

}  // namespace shutterline::engine
