#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/job/render_settings.h"
#include "worker/engine/scene/motion.h"
#include "worker/engine/scene/shutter_poses.h"
#include "worker/engine/scene/vertex_sets.h"

namespace shutterline::engine {

/// A node that draws a mesh, and its primitives' numbers in the frame.
struct PlacedMesh {
  int node = -1;
  const Mesh* mesh = nullptr;
  size_t first_primitive = 0;
  bool moves = false;  ///< It may move.
};

/// The motion of one placed mesh.
struct FittedMesh {
  /// Of those primitives that move; all of a mesh share them, so that borders between its primitives, which
  /// have equal vertices, stay closed.
  int degree = 0, pieces = 1;
  std::vector<char> moves;  ///< By primitive of the mesh: whether any vertex moves (else degree 0).
  /// Where no representation stays within tolerance (or the settings forbid it): by how much the chosen one
  /// misses the true path, and when.
  PathError error;
  double error_time = 0;
};

/// Of the primitives of meshes.
using MeshVertexSets = std::map<const Mesh*, std::shared_ptr<const std::vector<VertexSets>>>;

/// Chooses, for each placed mesh, the least motion that follows its path: no motion, else one curve of degree
/// 1, 2 or 3 over the shutter, else 2, 4, ... kMaxMotionPieces pieces of these degrees, the first that stays
/// within kPathPixels and kPathDepth of the exact places at all check times: several in each piece, none of
/// them where the curve passes through the path by construction, all keys of the animation and the times
/// half-way between them. Fewer pieces come before a lower degree, as a piece's length decides how far the
/// control points' bounds reach beyond the path.
///
/// Control points are in the camera's homogeneous space with w the distance from the camera, on all of a
/// primitive's vertices alike. So curves are polynomial, not rational: a weight of a vertex's own could draw
/// a circle exactly, but not at an even speed, and it would shift what is interpolated over the triangle.
class MotionFitter {
 public:
  /// `sets` has those of every mesh that is placed and may move.
  MotionFitter(const Scene& scene, const FrameView& view, const ShutterPoses& shutter,
               const RenderSettings& settings, std::span<const PlacedMesh> placed,
               const MeshVertexSets& sets);

  /// One a placed mesh; `open` is the moment at shutter open. A moment at which the camera has no orientation
  /// is not looked at, which `warnings` then tell.
  std::vector<FittedMesh> Fit(const Moment& open, std::vector<std::string>& warnings);

 private:
  /// The search's state for a mesh that is not decided.
  struct Search;
  struct Candidate {
    int degree, pieces;
  };

  std::vector<Candidate> Candidates() const;
  std::vector<double> CheckTimes(const Candidate& candidate) const;
  absl::StatusOr<Moment> MomentAt(double t);

  void FindWhatMoves(const Moment& open, std::span<Search> searches);
  void Try(const Candidate& candidate, std::span<Search> searches);
  bool PoseKnots(const Candidate& candidate, std::span<Search*> searches);
  void Check(const Candidate& candidate, bool all_vertices, bool stop_early, std::span<Search*> searches);
  void Measure(const Candidate& candidate, bool all_vertices, std::span<Search*> searches);
  void ChooseBest(std::span<Search> searches);

  const Scene& scene_;
  const FrameView& view_;
  const ShutterPoses& shutter_;
  const RenderSettings& settings_;
  const std::span<const PlacedMesh> placed_;
  const MeshVertexSets& sets_;
  std::vector<double> key_times_;  ///< Keys, and times half-way between them.
  std::vector<std::string> unposed_;
};

}  // namespace shutterline::engine
