#pragma once

#include <span>

#include "worker/engine/scene/motion.h"
#include "worker/engine/scene/vertex_sets.h"

namespace shutterline::engine {

/// Compares a piece of a primitive's motion, the curve of degree knots.size() - 1 through the places of
/// vertices in `knots` at equal intervals, with their true places at u in the piece. Runs in parallel over
/// vertices; results do not depend on how. Keeps references to what it is made of.
class CurveCheck {
 public:
  CurveCheck(const FrameView& view, const MeshPrimitive& primitive, const VertexSets& sets,
             std::span<const MeshPose> knots, double u)
      : view_(view), primitive_(primitive), sets_(sets), knots_(knots), u_(u) {}

  /// Whether every used vertex among `vertices` (empty: all) is within tolerance of its curve where `pose`
  /// has it, as PathErrorBetween says. Looks at the matrices alone where these tell.
  bool IsWithinTolerance(const MeshPose& pose, std::span<const uint32_t> vertices) const;

  /// The largest PathErrorBetween of the used ones.
  PathError LargestError(const MeshPose& pose, std::span<const uint32_t> vertices) const;

 private:
  /// Calls `f(path, fit)` for the used ones of a part of `vertices`, until it returns false.
  template <typename F>
  void ForEachPlace(const MeshPose& pose, std::span<const uint32_t> vertices, size_t begin, size_t end,
                    F f) const;
  size_t CountOf(std::span<const uint32_t> vertices) const {
    return vertices.empty() ? primitive_.positions.size() : vertices.size();
  }

  const FrameView& view_;
  const MeshPrimitive& primitive_;
  const VertexSets& sets_;
  const std::span<const MeshPose> knots_;
  const double u_;
};

}  // namespace shutterline::engine
