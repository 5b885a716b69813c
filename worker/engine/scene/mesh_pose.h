#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/camera_pose.h"
#include "worker/engine/scene/pose.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// A point, not a direction, by a matrix whose last column is that of an affine map.
inline V3d TransformPoint(const M44d& m, const V3d& p) {
  return {p.x * m[0][0] + p.y * m[1][0] + p.z * m[2][0] + m[3][0],
          p.x * m[0][1] + p.y * m[1][1] + p.z * m[2][1] + m[3][1],
          p.x * m[0][2] + p.y * m[1][2] + p.z * m[2][2] + m[3][2]};
}

/// A mesh as a node draws it at one time, in view space: morph targets, then skin or node transform, then
/// camera. A skinned primitive ignores the transform of its own node, as glTF demands; a primitive without
/// influences ignores the skin. A vertex's result depends on its own inputs alone and is bit-equal for
/// equal inputs. Immutable; keeps a reference to `scene`.
class MeshPose {
 public:
  MeshPose(const Scene& scene, int node, const Pose& pose, const CameraPose& camera);

  /// View space, metres. Not finite where the inputs are not or overflow.
  V3d Position(const MeshPrimitive& primitive, uint32_t vertex) const;

  /// The matrix, view from object, that places all vertices of a primitive alike; null where skin or morph
  /// targets place them one by one. Position is then TransformPoint with it.
  const M44d* MatrixOf(const MeshPrimitive& primitive) const;

  /// Normals of vertices [first, first + out.size()).
  void WriteNormals(const MeshPrimitive& primitive, uint32_t first, std::span<V3f> out) const;

  /// Unit normal in view space, by the inverse transpose; zero where there is no direction. The primitive
  /// must have normals.
  V3d Normal(const MeshPrimitive& primitive, uint32_t vertex) const;

  /// A direction on the surface at a vertex, `direction` in object space, as a unit vector in view space;
  /// zero where there is none. Morph targets do not turn it: glTF's offsets of tangents are not read, and a
  /// shading normal turns it upright.
  V3d Direction(const MeshPrimitive& primitive, uint32_t vertex, const V3d& direction) const;

  /// Whether the primitive is mirrored: the sign of the node's determinant, or, for skinned primitives, of
  /// the skin's first joint matrix that is regular.
  bool Mirrors(const MeshPrimitive& primitive) const;

 private:
  V3d MorphedNormal(const MeshPrimitive& primitive, uint32_t vertex) const;

  struct ActiveTarget {
    size_t target;
    double weight;
  };
  bool IsSkinned(const MeshPrimitive& primitive) const {
    return !view_from_bind_.empty() && !primitive.influences.empty();
  }

  M44d view_from_object_;
  std::vector<M44d> view_from_bind_;   ///< One a joint: inverse bind matrix, joint, camera.
  std::vector<ActiveTarget> targets_;  ///< Those with a weight other than zero.
};

}  // namespace shutterline::engine
