#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/vertex_sets.h"

namespace shutterline::engine {

struct AnimationChannel;
class PoseSampler;

/// What frames of a scene find out about it that is the same in all of them: made when first asked for, then
/// kept. Belongs to the scene and dies with it. Takes a byte a stored vertex. Thread-safe. A copy starts
/// empty: it may belong to other meshes.
class SharedFacts {
 public:
  SharedFacts() = default;
  SharedFacts(const SharedFacts&) {}
  SharedFacts& operator=(const SharedFacts&);

  /// Of the primitives of meshes[mesh]; the meshes must be those of the scene that owns this, always.
  std::shared_ptr<const std::vector<VertexSets>> VertexSetsOf(const std::vector<Mesh>& meshes,
                                                              size_t mesh) const;

  /// AnimationBounds of a sampler of the scene that owns this.
  Box3d BoundsOf(const PoseSampler& sampler) const;

 private:
  using Channels = std::vector<const AnimationChannel*>;

  mutable std::mutex mutex_;
  mutable std::vector<std::shared_ptr<const std::vector<VertexSets>>> vertex_sets_;  ///< By mesh.
  mutable std::list<std::pair<Channels, Box3d>> bounds_;                             ///< The latest first.
};

}  // namespace shutterline::engine
