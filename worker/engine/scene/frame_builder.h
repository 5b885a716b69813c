#pragma once

#include <absl/status/status.h>

#include <memory>
#include <string>
#include <vector>

#include "common/job/render_settings.h"
#include "worker/engine/scene/auto_camera.h"
#include "worker/engine/scene/camera_select.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/mesh_pose.h"
#include "worker/engine/scene/pose.h"

namespace shutterline::engine {

/// One run of BuildFrameScene: its steps, in the order in which Build takes them, and what they share.
class FrameBuilder {
 public:
  FrameBuilder(std::shared_ptr<const Scene> scene, std::vector<const AnimationChannel*> channels,
               CameraChoice choice, int frame, const RenderSettings& settings);

  absl::Status Build();
  std::shared_ptr<const FrameScene> Take() { return std::move(frame_); }

 private:
  /// All nodes and the camera at one time.
  struct Moment {
    Pose pose;
    CameraPose camera;
  };
  /// A node that draws a mesh, and its primitives' numbers in the frame.
  struct PlacedMesh {
    int node = -1;
    const Mesh* mesh = nullptr;
    size_t first_primitive = 0;
    bool moves = false;
  };

  absl::StatusOr<Moment> MomentAt(double t) const;
  MeshPose PoseOf(const PlacedMesh& placed, const Moment& moment) const;

  absl::Status MakeView();
  absl::Status PlaceMeshes();
  void FindDegrees(const Moment& open, const Moment& close);
  void LayOutVertices();
  void EvaluateVertices(const Moment& open, const Moment& close, const Moment& middle);
  void MakeTriangles();
  void CheckPaths();
  void MakeTextures();
  /// "node 3 "wheel", mesh "Wheel", primitive 0".
  std::string NameOf(const FramePrimitive& primitive) const;

  const Scene& scene_;
  const CameraChoice choice_;
  const double open_seconds_, close_seconds_;
  const RenderSettings& settings_;
  const PoseSampler sampler_;
  std::optional<AutoCamera> auto_camera_;
  bool camera_moves_ = false;
  bool anything_moves_ = false;
  std::vector<PlacedMesh> placed_;
  std::vector<char> usable_;  ///< One a primitive: all its control points are.
  std::shared_ptr<FrameScene> frame_;
};

}  // namespace shutterline::engine
