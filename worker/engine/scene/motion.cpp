#include "worker/engine/scene/motion.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine {
namespace {

constexpr size_t kVerticesPerTask = 4096;

bool IsInFront(const RasterPoint& p) {
  return p.w > 0 && p.z <= p.w;
}

V2d RasterPosition(const RasterPoint& p) {
  return {p.x / p.w, p.y / p.w};
}

bool IsInFrame(const FrameView& view, const V2d& p) {
  return p.x >= 0 && p.x <= view.width && p.y >= 0 && p.y <= view.height;
}

double PathLength(const RasterPoint& open, const RasterPoint& close) {
  if (open == close) return 0;
  if (!IsInFront(open) || !IsInFront(close)) return std::numeric_limits<double>::infinity();
  const V2d step = RasterPosition(close) - RasterPosition(open);
  return std::hypot(step.x, step.y);
}

ControlPointFacts Merge(const ControlPointFacts& a, const ControlPointFacts& b) {
  return {a.all_usable && b.all_usable, std::max(a.motion_pixels, b.motion_pixels)};
}

}  // namespace

bool IsUsable(const RasterPoint& p) {
  // A comparison with NaN is false.
  return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
         std::abs(p.z) <= kMaxCoordinate && std::abs(p.w) <= kMaxCoordinate;
}

bool AnyVertexMoves(const FrameView& view, const MeshPrimitive& primitive, const MeshPose& open,
                    const MeshPose& close) {
  for (uint32_t v = 0; v < primitive.positions.size(); ++v) {
    const RasterPoint a = view.RasterFromView(open.Position(primitive, v));
    const RasterPoint b = view.RasterFromView(close.Position(primitive, v));
    // A vertex that becomes unusable half-way counts as moving, so that its triangles are dropped; one that
    // is unusable at both ends is dropped as it is.
    if (IsUsable(a) != IsUsable(b)) return true;
    if (!(a == b) && IsUsable(a)) return true;
  }
  return false;
}

ControlPointFacts WriteControlPoints(const FrameView& view, const MeshPrimitive& primitive, int degree,
                                     const MeshPose& open, const MeshPose& close,
                                     std::span<RasterPoint> control_points) {
  const size_t count = primitive.positions.size();
  SL_CHECK(control_points.size() == count * size_t(degree + 1));
  const std::vector<uint8_t> used = degree > 0 ? UsedVertices(primitive) : std::vector<uint8_t>();
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, count, kVerticesPerTask), ControlPointFacts(),
      [&](const tbb::blocked_range<size_t>& range, ControlPointFacts facts) {
        for (size_t v = range.begin(); v < range.end(); ++v) {
          const RasterPoint a = view.RasterFromView(open.Position(primitive, uint32_t(v)));
          control_points[v * size_t(degree + 1)] = a;
          bool usable = IsUsable(a);
          if (degree > 0) {
            const RasterPoint b = view.RasterFromView(close.Position(primitive, uint32_t(v)));
            control_points[v * 2 + 1] = b;
            usable = usable && IsUsable(b);
            if (usable && used[v]) facts.motion_pixels = std::max(facts.motion_pixels, PathLength(a, b));
          }
          facts.all_usable = facts.all_usable && usable;
        }
        return facts;
      },
      Merge);
}

double PathDeviation(const FrameScene& frame, const FramePrimitive& primitive, const MeshPose& pose,
                     double t) {
  const MeshPrimitive& source = *primitive.source;
  const std::vector<uint8_t> used = UsedVertices(source);
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, used.size(), kVerticesPerTask), 0.0,
      [&](const tbb::blocked_range<size_t>& range, double largest) {
        for (size_t v = range.begin(); v < range.end(); ++v) {
          if (!used[v]) continue;
          const RasterPoint straight = frame.VertexAt(primitive, primitive.first_vertex + uint32_t(v), t);
          const RasterPoint real = frame.view.RasterFromView(pose.Position(source, uint32_t(v)));
          if (!IsUsable(straight) || !IsUsable(real) || !IsInFront(straight) || !IsInFront(real)) continue;
          const V2d a = RasterPosition(straight), b = RasterPosition(real);
          if (!IsInFrame(frame.view, a) && !IsInFrame(frame.view, b)) continue;
          largest = std::max(largest, std::hypot(a.x - b.x, a.y - b.y));
        }
        return largest;
      },
      [](double a, double b) { return std::max(a, b); });
}

}  // namespace shutterline::engine
