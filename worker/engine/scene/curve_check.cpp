#include "worker/engine/scene/curve_check.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <array>
#include <atomic>

#include "common/base/work_limit.h"
#include "worker/engine/scene/affine_path.h"

namespace shutterline::engine {
namespace {

constexpr size_t kPathsPerTask = 1024;

}  // namespace

template <typename F>
void CurveCheck::ForEachPlace(const MeshPose& pose, std::span<const uint32_t> vertices, size_t begin,
                              size_t end, F f) const {
  const size_t points = knots_.size();
  for (size_t i = begin; i < end; ++i) {
    const uint32_t vertex = vertices.empty() ? uint32_t(i) : vertices[i];
    if (!sets_.used[vertex]) continue;
    std::array<RasterPoint, kMaxBezierDegree + 1> curve;
    for (size_t k = 0; k < points; ++k) {
      curve[k] = view_.RasterFromView(knots_[k].Position(primitive_, vertex));
    }
    InterpolateBezier(std::span(curve).first(points));
    const RasterPoint fit = BezierPoint(curve.data(), int(points) - 1, u_);
    if (!f(view_.RasterFromView(pose.Position(primitive_, vertex)), fit)) return;
  }
}

bool CurveCheck::IsWithinTolerance(const MeshPose& pose, std::span<const uint32_t> vertices) const {
  if (const M44d* const path = pose.MatrixOf(primitive_)) {
    std::array<const M44d*, kMaxBezierDegree + 1> knots{};
    bool are_known = true;
    for (size_t k = 0; k < knots_.size(); ++k) {
      knots[k] = knots_[k].MatrixOf(primitive_);
      are_known = are_known && knots[k] != nullptr;
    }
    if (are_known &&
        AffinePathIsFollowed(view_, sets_.box, std::span(knots).first(knots_.size()), u_, *path)) {
      return true;
    }
  }
  const WorkLimit* const limit = WorkLimit::Current();
  std::atomic<bool> all_within = true;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, CountOf(vertices), kPathsPerTask),
                    [&](const tbb::blocked_range<size_t>& range) {
                      if (!all_within.load(std::memory_order_relaxed)) return;
                      CheckWork(limit);
                      ForEachPlace(pose, vertices, range.begin(), range.end(),
                                   [&](const RasterPoint& path, const RasterPoint& fit) {
                                     if (IsSurelyWithinTolerance(view_, path, fit)) return true;
                                     PathError error;
                                     error.Extend(PathErrorBetween(view_, path, fit));
                                     if (error.IsWithinTolerance()) return true;
                                     all_within.store(false, std::memory_order_relaxed);
                                     return false;
                                   });
                    });
  return all_within;
}

PathError CurveCheck::LargestError(const MeshPose& pose, std::span<const uint32_t> vertices) const {
  const WorkLimit* const limit = WorkLimit::Current();
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, CountOf(vertices), kPathsPerTask), PathError(),
      [&](const tbb::blocked_range<size_t>& range, PathError error) {
        CheckWork(limit);
        ForEachPlace(pose, vertices, range.begin(), range.end(),
                     [&](const RasterPoint& path, const RasterPoint& fit) {
                       error.Extend(PathErrorBetween(view_, path, fit));
                       return true;
                     });
        return error;
      },
      [](PathError a, const PathError& b) {
        a.Extend(b);
        return a;
      });
}

}  // namespace shutterline::engine
