#include "worker/engine/scene/vertex_sets.h"

#include <algorithm>
#include <cmath>

#include "worker/engine/scene/scene.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine {
namespace {

/// Representations are tried on about so many vertices of a primitive before all are looked at.
constexpr size_t kTriedVertices = 256;

}  // namespace

VertexSets MakeVertexSets(const MeshPrimitive& primitive) {
  VertexSets sets;
  sets.used = UsedVertices(primitive);
  Box3f box;
  bool is_finite = true;
  for (size_t v = 0; v < sets.used.size(); ++v) {
    if (!sets.used[v]) continue;
    const V3f& p = primitive.positions[v];
    is_finite = is_finite && std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    box.extendBy(p);
  }
  sets.box = Box3d(V3d(box.min), V3d(box.max));
  if (!is_finite) sets.box.makeInfinite();

  const size_t used = size_t(std::count(sets.used.begin(), sets.used.end(), 1));
  const size_t stride = used / kTriedVertices;
  if (stride < 2) return sets;
  size_t number = 0;
  for (uint32_t v = 0; v < sets.used.size(); ++v) {
    if (sets.used[v] && number++ % stride == 0) sets.tried.push_back(v);
  }
  return sets;
}

}  // namespace shutterline::engine
