#pragma once

#include <map>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Where every node is at one time.
struct Pose {
  std::vector<M44d> world_from_node;  ///< One a node.
  /// Morph weights of the nodes whose weights are animated.
  std::map<int, std::vector<double>> weights;
};

/// Poses a scene's nodes at any time under the selected animation channels. Immutable after construction,
/// so any number of threads may use it. Keeps references to `scene` and the channels.
class PoseSampler {
 public:
  PoseSampler(const Scene& scene, std::vector<const AnimationChannel*> channels);

  /// `time` in seconds of animation. Equal times give bit-equal poses.
  Pose At(double time) const;

  /// Whether the node's place in the world can change: it or a node above it has a channel.
  bool Moves(int node) const { return moves_[size_t(node)] != 0; }
  bool WeightsMove(int node) const { return weights_move_[size_t(node)] != 0; }

  /// Whether what a node draws can change relative to the world: by its transform, its joints or its
  /// morph weights.
  bool MeshMoves(int node) const;

  /// The distinct key times t with open < t < close, ascending; at most `max_count` of them, taken evenly
  /// from all.
  std::vector<double> KeyTimes(double open, double close, size_t max_count) const;

  /// First and last key time of all channels, seconds; {0, 0} without channels.
  std::pair<double, double> KeyRange() const;

  const Scene& scene() const { return scene_; }
  const std::vector<const AnimationChannel*>& channels() const { return channels_; }

 private:
  const Scene& scene_;
  std::vector<const AnimationChannel*> channels_;
  std::vector<int> moving_order_;       ///< Nodes that move, parents before children.
  std::vector<M44d> rest_;              ///< World from node; as it always is for those that do not move.
  std::vector<int> animated_;           ///< Nodes whose own transforms have channels.
  std::vector<int> place_in_animated_;  ///< One a node; -1: none.
  std::vector<char> moves_, weights_move_;
  std::vector<char> skin_moves_;  ///< One a skin: one of its joints moves.
};

/// The node's own matrix, parent from node, in the row-vector convention.
M44d LocalMatrix(const NodeTransform& transform);

/// The nodes of the default scene, parents before children and otherwise in the file's order.
std::vector<int> NodesInDefaultScene(const Scene& scene);

}  // namespace shutterline::engine
