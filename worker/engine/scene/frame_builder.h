#pragma once

#include <absl/status/status.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/job/render_settings.h"
#include "worker/engine/scene/auto_camera.h"
#include "worker/engine/scene/camera_select.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/mesh_pose.h"
#include "worker/engine/scene/motion_fit.h"
#include "worker/engine/scene/shutter_poses.h"

namespace shutterline::engine {

/// One run of BuildFrameScene: its steps, in the order in which Build takes them, and what they share.
class FrameBuilder {
 public:
  FrameBuilder(std::shared_ptr<const Scene> scene, std::vector<const AnimationChannel*> channels,
               CameraChoice choice, int frame, const RenderSettings& settings);

  absl::Status Build();
  std::shared_ptr<const FrameScene> Take() { return std::move(frame_); }

 private:
  absl::Status MakeView();
  absl::Status PlaceMeshes();
  void FitMotion(const Moment& open);
  /// `still` is the moment for what does not move.
  absl::Status LayOutVertices(const Moment& still);
  void EvaluateNormals(const Moment& moment);
  /// After the triangles: tangents are by their corners.
  void EvaluateTangents(const Moment& moment);
  void WriteTangents(const MeshPose& pose, size_t primitive);
  void MakeTriangles();
  bool IsDrawn(const FramePrimitive& primitive, const std::array<uint32_t, 3>& triangle) const;
  void NameMisses();
  void MakeTextures();
  /// "node 3 "wheel", mesh 2 "Wheel"", and the same with ", primitive 0".
  std::string NameOf(const PlacedMesh& placed) const;
  std::string NameOf(const FramePrimitive& primitive) const;

  const Scene& scene_;
  const CameraChoice choice_;
  const RenderSettings& settings_;
  ShutterPoses shutter_;
  std::optional<AutoCamera> auto_camera_;
  bool anything_moves_ = false;  ///< Of what is drawn or gives light.
  std::vector<PlacedMesh> placed_;
  MeshVertexSets vertex_sets_;      ///< Of placed meshes that may move.
  std::vector<FittedMesh> fitted_;  ///< One a placed mesh.
  std::vector<char> usable_;        ///< One a primitive: all its control points are.
  std::shared_ptr<FrameScene> frame_;
};

}  // namespace shutterline::engine
