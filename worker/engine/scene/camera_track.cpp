#include "worker/engine/scene/camera_track.h"

#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/scene/animation_select.h"
#include "worker/engine/scene/shutter_poses.h"

namespace shutterline::engine {
namespace {

/// What places nodes.
std::shared_ptr<const Scene> NodesOf(const Scene& scene) {
  auto nodes = std::make_shared<Scene>();
  nodes->name = scene.name;
  nodes->roots = scene.roots;
  nodes->nodes = scene.nodes;
  nodes->skins = scene.skins;
  nodes->animations = scene.animations;
  return nodes;
}

/// What RasterFromView does and a division by the picture's sides, for row vectors.
M44d NdcFromView(const FrameView& v) {
  const double x = 1.0 / v.width, y = 1.0 / v.height;
  M44d ndc(v.scale_x * x, 0, 0, 0, 0, -v.scale_y * y, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
  if (v.perspective) {
    ndc[2][0] = -v.center_x * x;
    ndc[2][1] = -v.center_y * y;
    ndc[2][3] = -1;
    ndc[3][2] = v.znear;
    return ndc;
  }
  const double per_depth = 1 / (v.zfar - v.znear);
  ndc[2][2] = per_depth;
  ndc[3][0] = v.center_x * x;
  ndc[3][1] = v.center_y * y;
  ndc[3][2] = v.zfar * per_depth;
  ndc[3][3] = 1;
  return ndc;
}

}  // namespace

absl::StatusOr<CameraTrack> CameraTrack::Make(const Scene& scene, const RenderSettings& settings) {
  SL_ASSIGN_OR_RETURN(const CameraChoice choice, SelectCamera(scene, settings.camera));
  std::shared_ptr<const Scene> nodes = NodesOf(scene);
  SL_ASSIGN_OR_RETURN(std::vector<const AnimationChannel*> channels,
                      SelectChannels(*nodes, settings.animation));
  PoseSampler sampler(*nodes, std::move(channels));
  CameraTrack track(std::move(nodes), std::move(sampler), settings);
  Camera camera;
  if (choice.IsAutomatic()) {
    SL_ASSIGN_OR_RETURN(std::vector<const AnimationChannel*> all, SelectChannels(scene, settings.animation));
    const AutoCamera made = MakeAutoCamera(scene.facts.BoundsOf(PoseSampler(scene, std::move(all))),
                                           settings.width, settings.height);
    camera = made.camera;
    track.fixed_ = made.pose;
  } else {
    camera = scene.cameras[size_t(choice.camera)];
    track.node_ = choice.node;
  }
  SL_ASSIGN_OR_RETURN(track.view_, MakeFrameView(camera, settings.width, settings.height));
  return track;
}

absl::StatusOr<CameraMatrices> CameraTrack::At(int frame) const {
  ShutterPoses shutter(*nodes_, sampler_, node_, (frame + open_) / fps_, (frame + close_) / fps_);
  if (fixed_) shutter.SetFixedCamera(*fixed_);
  SL_ASSIGN_OR_RETURN(const Moment middle, shutter.At(0.5));
  const M44d view_from_world = middle.camera.ViewFrom(M44d());
  // In view space cameras look along -z; OpenEXR's look along z.
  M44d forward;
  forward[2][2] = -1;
  return CameraMatrices{.world_to_camera = view_from_world * forward,
                        .world_to_ndc = view_from_world * NdcFromView(view_)};
}

}  // namespace shutterline::engine
