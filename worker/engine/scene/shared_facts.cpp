#include "worker/engine/scene/shared_facts.h"

#include <algorithm>

#include "worker/engine/scene/scene.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine {
namespace {

/// Selections of channels whose bounds are kept. A job has one.
constexpr size_t kKeptBounds = 4;

}  // namespace

SharedFacts& SharedFacts::operator=(const SharedFacts& other) {
  if (this != &other) {
    const std::lock_guard lock(mutex_);
    vertex_sets_.clear();
    bounds_.clear();
  }
  return *this;
}

std::shared_ptr<const std::vector<VertexSets>> SharedFacts::VertexSetsOf(const std::vector<Mesh>& meshes,
                                                                         size_t mesh) const {
  {
    const std::lock_guard lock(mutex_);
    if (vertex_sets_.size() != meshes.size()) vertex_sets_.assign(meshes.size(), nullptr);
    if (const auto& made = vertex_sets_[mesh]) return made;
  }
  // Made without the lock; if two threads make the same, the first to finish wins and both are equal.
  auto made = std::make_shared<std::vector<VertexSets>>();
  for (const MeshPrimitive& primitive : meshes[mesh].primitives) made->push_back(MakeVertexSets(primitive));
  const std::lock_guard lock(mutex_);
  auto& slot = vertex_sets_[mesh];
  if (!slot) slot = std::move(made);
  return slot;
}

Box3d SharedFacts::BoundsOf(const PoseSampler& sampler) const {
  const auto find = [&]() -> const Box3d* {
    const auto found = std::find_if(bounds_.begin(), bounds_.end(),
                                    [&](const auto& kept) { return kept.first == sampler.channels(); });
    return found == bounds_.end() ? nullptr : &found->second;
  };
  {
    const std::lock_guard lock(mutex_);
    if (const Box3d* kept = find()) return *kept;
  }
  const Box3d made = AnimationBounds(sampler);
  const std::lock_guard lock(mutex_);
  if (find() == nullptr) bounds_.emplace_front(sampler.channels(), made);
  if (bounds_.size() > kKeptBounds) bounds_.pop_back();
  return made;
}

}  // namespace shutterline::engine
