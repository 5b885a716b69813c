#include "worker/engine/scene/pose.h"

#include <algorithm>
#include <utility>

#include "worker/engine/scene/keyframes.h"

namespace shutterline::engine {
namespace {

/// Nodes reached from `starts`, depth first, parents before children, each once. Iterative: trees may be
/// as deep as the importer allows.
std::vector<int> Preorder(const Scene& scene, const std::vector<int>& starts) {
  std::vector<int> order;
  std::vector<char> seen(scene.nodes.size(), 0);
  std::vector<int> stack(starts.rbegin(), starts.rend());
  while (!stack.empty()) {
    const int node = stack.back();
    stack.pop_back();
    if (std::exchange(seen[size_t(node)], 1)) continue;
    order.push_back(node);
    const std::vector<int>& children = scene.nodes[size_t(node)].children;
    stack.insert(stack.end(), children.rbegin(), children.rend());
  }
  return order;
}

}  // namespace

M44d LocalMatrix(const NodeTransform& transform) {
  if (transform.has_matrix) return transform.matrix;
  M44d m = transform.rotation.toMatrix44();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) m[row][column] *= transform.scale[row];
  }
  for (int column = 0; column < 3; ++column) m[3][column] = transform.translation[column];
  return m;
}

std::vector<int> NodesInDefaultScene(const Scene& scene) {
  return Preorder(scene, scene.roots);
}

PoseSampler::PoseSampler(const Scene& scene, std::vector<const AnimationChannel*> channels)
    : scene_(scene), channels_(std::move(channels)) {
  const size_t count = scene.nodes.size();
  std::vector<int> tops;
  for (size_t i = 0; i < count; ++i) {
    if (scene.nodes[i].parent < 0) tops.push_back(int(i));
  }
  const std::vector<int> order = Preorder(scene, tops);
  moves_.assign(count, 0);
  weights_move_.assign(count, 0);
  place_in_animated_.assign(count, -1);
  for (const AnimationChannel* channel : channels_) {
    const size_t node = size_t(channel->node);
    if (channel->path == AnimatedPath::kWeights) {
      weights_move_[node] = 1;
      continue;
    }
    if (!scene.nodes[node].transform.has_matrix) moves_[node] = 1;
    if (place_in_animated_[node] >= 0) continue;
    place_in_animated_[node] = int(animated_.size());
    animated_.push_back(channel->node);
  }
  rest_.resize(count);
  for (const int node : order) {
    const Node& n = scene.nodes[size_t(node)];
    if (n.parent >= 0 && moves_[size_t(n.parent)]) moves_[size_t(node)] = 1;
    if (moves_[size_t(node)]) moving_order_.push_back(node);
    const M44d local = LocalMatrix(n.transform);
    rest_[size_t(node)] = n.parent < 0 ? local : local * rest_[size_t(n.parent)];
  }
  skin_moves_.assign(scene.skins.size(), 0);
  for (size_t i = 0; i < scene.skins.size(); ++i) {
    const std::vector<int>& joints = scene.skins[i].joints;
    skin_moves_[i] = std::any_of(joints.begin(), joints.end(), [&](int joint) { return Moves(joint); });
  }
}

Pose PoseSampler::At(double time) const {
  // Replace what the channels animate in the nodes' own transforms.
  std::vector<NodeTransform> transforms;
  transforms.reserve(animated_.size());
  for (const int node : animated_) transforms.push_back(scene_.nodes[size_t(node)].transform);
  Pose pose;
  std::vector<double> value;
  for (const AnimationChannel* channel : channels_) {
    value.resize(size_t(channel->width));
    SampleChannel(*channel, time, value);
    if (channel->path == AnimatedPath::kWeights) {
      pose.weights[channel->node] = value;
      continue;
    }
    NodeTransform& transform = transforms[size_t(place_in_animated_[size_t(channel->node)])];
    if (channel->path == AnimatedPath::kTranslation) {
      transform.translation = {value[0], value[1], value[2]};
    } else if (channel->path == AnimatedPath::kScale) {
      transform.scale = {value[0], value[1], value[2]};
    } else {
      transform.rotation = Quatd(value[3], value[0], value[1], value[2]);
    }
  }

  // Multiply down the trees.
  pose.world_from_node = rest_;
  for (const int node : moving_order_) {
    const Node& n = scene_.nodes[size_t(node)];
    const int place = place_in_animated_[size_t(node)];
    const M44d local = LocalMatrix(place < 0 ? n.transform : transforms[size_t(place)]);
    pose.world_from_node[size_t(node)] =
        n.parent < 0 ? local : local * pose.world_from_node[size_t(n.parent)];
  }
  return pose;
}

bool PoseSampler::MeshMoves(int node) const {
  const Node& n = scene_.nodes[size_t(node)];
  return Moves(node) || WeightsMove(node) || (n.skin >= 0 && skin_moves_[size_t(n.skin)]);
}

std::vector<double> PoseSampler::KeyTimes(double open, double close, size_t max_count) const {
  std::vector<double> times;
  for (const AnimationChannel* channel : channels_) {
    const auto first = std::upper_bound(channel->times.begin(), channel->times.end(), open);
    const auto last = std::lower_bound(first, channel->times.end(), close);
    times.insert(times.end(), first, last);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (times.size() <= max_count) return times;
  std::vector<double> chosen;
  for (size_t i = 0; i < max_count; ++i)
    chosen.push_back(times[(2 * i + 1) * times.size() / (2 * max_count)]);
  return chosen;
}

std::pair<double, double> PoseSampler::KeyRange() const {
  if (channels_.empty()) return {0, 0};
  std::pair<double, double> range{channels_[0]->times.front(), channels_[0]->times.back()};
  for (const AnimationChannel* channel : channels_) {
    range.first = std::min<double>(range.first, channel->times.front());
    range.second = std::max<double>(range.second, channel->times.back());
  }
  return range;
}

}  // namespace shutterline::engine
