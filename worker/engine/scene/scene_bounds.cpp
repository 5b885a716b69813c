#include "worker/engine/scene/scene_bounds.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cmath>

#include "common/base/work_limit.h"
#include "worker/engine/scene/mesh_pose.h"

namespace shutterline::engine {
namespace {

constexpr uint32_t kVerticesPerCheck = 1024;

bool IsFinite(const V3d& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

Box3d Union(Box3d a, const Box3d& b) {
  a.extendBy(b);
  return a;
}

}  // namespace

std::vector<uint8_t> UsedVertices(const MeshPrimitive& primitive) {
  std::vector<uint8_t> used(primitive.positions.size(), 0);
  for (const std::array<uint32_t, 3>& triangle : primitive.triangles) {
    for (const uint32_t vertex : triangle) used[vertex] = 1;
  }
  return used;
}

Box3d WorldBounds(const Scene& scene, const std::vector<int>& mesh_nodes, const Pose& pose) {
  const WorkLimit* const limit = WorkLimit::Current();
  // Minima and maxima are exact, so the order of the reduction does not matter.
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, mesh_nodes.size()), Box3d(),
      [&](const tbb::blocked_range<size_t>& range, Box3d box) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          CheckWork(limit);
          const MeshPose mesh_pose(scene, mesh_nodes[i], pose, CameraPose());
          const size_t mesh = size_t(scene.nodes[size_t(mesh_nodes[i])].mesh);
          const auto sets = scene.facts.VertexSetsOf(scene.meshes, mesh);
          for (size_t k = 0; k < sets->size(); ++k) {
            const MeshPrimitive& primitive = scene.meshes[mesh].primitives[k];
            const std::vector<uint8_t>& used = (*sets)[k].used;
            for (uint32_t v = 0; v < used.size(); ++v) {
              if (v % kVerticesPerCheck == 0) CheckWork(limit);
              if (!used[v]) continue;
              const V3d p = mesh_pose.Position(primitive, v);
              if (IsFinite(p)) box.extendBy(p);
            }
          }
        }
        return box;
      },
      Union);
}

Box3d AnimationBounds(const PoseSampler& sampler) {
  const Scene& scene = sampler.scene();
  std::vector<int> still, moving;
  for (const int node : NodesInDefaultScene(scene)) {
    if (scene.nodes[size_t(node)].mesh < 0) continue;
    (sampler.MeshMoves(node) ? moving : still).push_back(node);
  }
  const auto [first, last] = sampler.KeyRange();
  Box3d box = WorldBounds(scene, still, sampler.At(first));
  if (moving.empty()) return box;
  for (int i = 0; i < kBoundsSamples; ++i) {
    const double u = double(i) / (kBoundsSamples - 1);
    box.extendBy(WorldBounds(scene, moving, sampler.At((1 - u) * first + u * last)));
  }
  return box;
}

}  // namespace shutterline::engine
