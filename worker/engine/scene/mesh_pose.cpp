#include "worker/engine/scene/mesh_pose.h"

#include <algorithm>
#include <cmath>

#include "common/math/unit_vector.h"

namespace shutterline::engine {
namespace {

/// The rows of a matrix's upper left 3 x 3 part.
struct Linear {
  V3d a{0, 0, 0}, b{0, 0, 0}, c{0, 0, 0};

  Linear() = default;
  explicit Linear(const M44d& m)
      : a(m[0][0], m[0][1], m[0][2]), b(m[1][0], m[1][1], m[1][2]), c(m[2][0], m[2][1], m[2][2]) {}

  void Add(double weight, const M44d& m) {
    const Linear other(m);
    a += weight * other.a;
    b += weight * other.b;
    c += weight * other.c;
  }

  /// Scales the largest entry to 1, so that determinants neither overflow nor vanish in tiny scenes.
  void Normalize() {
    double largest = 0;
    for (const V3d* row : {&a, &b, &c}) {
      largest = std::max({largest, std::abs(row->x), std::abs(row->y), std::abs(row->z)});
    }
    if (!(largest > 0)) return;
    a /= largest;
    b /= largest;
    c /= largest;
  }
  double Determinant() const { return a.dot(b.cross(c)); }
};

/// The map of a skinned vertex: its joints' blended, or its first joint's where none has weight.
Linear Blended(const std::vector<M44d>& view_from_bind, const VertexInfluences& influences) {
  Linear linear;
  bool any = false;
  for (size_t k = 0; k < influences.weights.size(); ++k) {
    if (influences.weights[k] == 0) continue;
    linear.Add(influences.weights[k], view_from_bind[influences.joints[k]]);
    any = true;
  }
  return any ? linear : Linear(view_from_bind[influences.joints[0]]);
}

/// What takes normals to view space: the inverse transpose, but for a factor.
class NormalMap {
 public:
  explicit NormalMap(Linear linear) {
    // The cofactors are the inverse transpose times the determinant, of which only the sign matters.
    linear.Normalize();
    x_ = linear.b.cross(linear.c);
    y_ = linear.c.cross(linear.a);
    z_ = linear.a.cross(linear.b);
    mirrors_ = linear.Determinant() < 0;
  }

  V3d operator()(const V3d& n) const {
    const V3d normal = n.x * x_ + n.y * y_ + n.z * z_;
    return UnitOrZero(mirrors_ ? -normal : normal);
  }

 private:
  V3d x_, y_, z_;
  bool mirrors_;
};

std::vector<double> MorphWeights(const Scene& scene, int node, const Pose& pose) {
  const auto animated = pose.weights.find(node);
  if (animated != pose.weights.end()) return animated->second;
  const Node& n = scene.nodes[size_t(node)];
  const std::vector<float>& weights = n.weights.empty() ? scene.meshes[size_t(n.mesh)].weights : n.weights;
  return {weights.begin(), weights.end()};
}

}  // namespace

MeshPose::MeshPose(const Scene& scene, int node, const Pose& pose, const CameraPose& camera)
    : view_from_object_(camera.ViewFrom(pose.world_from_node[size_t(node)])) {
  const Node& n = scene.nodes[size_t(node)];
  if (n.skin >= 0) {
    // The camera goes in before joints are blended: an error of the weights' sum is then a scaling about
    // the camera and not about the world's origin.
    const Skin& skin = scene.skins[size_t(n.skin)];
    view_from_bind_.reserve(skin.joints.size());
    for (size_t i = 0; i < skin.joints.size(); ++i) {
      view_from_bind_.push_back(skin.inverse_bind_matrices[i] *
                                camera.ViewFrom(pose.world_from_node[size_t(skin.joints[i])]));
    }
  }
  const std::vector<double> weights = MorphWeights(scene, node, pose);
  for (size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] != 0) targets_.push_back({i, weights[i]});
  }
}

V3d MeshPose::Position(const MeshPrimitive& primitive, uint32_t vertex) const {
  V3d p(primitive.positions[vertex]);
  for (const ActiveTarget& active : targets_) {
    if (active.target >= primitive.targets.size()) break;
    const std::vector<V3f>& offsets = primitive.targets[active.target].positions;
    if (!offsets.empty()) p += active.weight * V3d(offsets[vertex]);
  }
  if (!IsSkinned(primitive)) return TransformPoint(view_from_object_, p);

  const VertexInfluences& influences = primitive.influences[vertex];
  V3d sum(0);
  double total = 0;
  for (size_t k = 0; k < influences.weights.size(); ++k) {
    const double weight = influences.weights[k];
    if (weight == 0) continue;
    sum += weight * TransformPoint(view_from_bind_[influences.joints[k]], p);
    total += weight;
  }
  // Without any weight the vertex follows its first joint.
  return total != 0 ? sum / total : TransformPoint(view_from_bind_[influences.joints[0]], p);
}

const M44d* MeshPose::MatrixOf(const MeshPrimitive& primitive) const {
  if (IsSkinned(primitive)) return nullptr;
  for (const ActiveTarget& active : targets_) {
    if (active.target < primitive.targets.size() && !primitive.targets[active.target].positions.empty()) {
      return nullptr;
    }
  }
  return &view_from_object_;
}

V3d MeshPose::MorphedNormal(const MeshPrimitive& primitive, uint32_t vertex) const {
  V3d n(primitive.normals[vertex]);
  for (const ActiveTarget& active : targets_) {
    if (active.target >= primitive.targets.size()) break;
    const std::vector<V3f>& offsets = primitive.targets[active.target].normals;
    if (!offsets.empty()) n += active.weight * V3d(offsets[vertex]);
  }
  return n;
}

V3d MeshPose::Normal(const MeshPrimitive& primitive, uint32_t vertex) const {
  const Linear linear = IsSkinned(primitive) ? Blended(view_from_bind_, primitive.influences[vertex])
                                             : Linear(view_from_object_);
  return NormalMap(linear)(MorphedNormal(primitive, vertex));
}

V3d MeshPose::Direction(const MeshPrimitive& primitive, uint32_t vertex, const V3d& direction) const {
  const Linear linear = IsSkinned(primitive) ? Blended(view_from_bind_, primitive.influences[vertex])
                                             : Linear(view_from_object_);
  return UnitOrZero(direction.x * linear.a + direction.y * linear.b + direction.z * linear.c);
}

void MeshPose::WriteNormals(const MeshPrimitive& primitive, uint32_t first, std::span<V3f> out) const {
  if (IsSkinned(primitive)) {
    for (size_t i = 0; i < out.size(); ++i) out[i] = V3f(Normal(primitive, first + uint32_t(i)));
    return;
  }
  const NormalMap map{Linear(view_from_object_)};
  for (size_t i = 0; i < out.size(); ++i) out[i] = V3f(map(MorphedNormal(primitive, first + uint32_t(i))));
}

bool MeshPose::Mirrors(const MeshPrimitive& primitive) const {
  if (IsSkinned(primitive)) {
    for (const M44d& matrix : view_from_bind_) {
      Linear linear(matrix);
      linear.Normalize();
      if (const double determinant = linear.Determinant(); determinant != 0) return determinant < 0;
    }
    return false;
  }
  Linear linear(view_from_object_);
  linear.Normalize();
  return linear.Determinant() < 0;
}

}  // namespace shutterline::engine
