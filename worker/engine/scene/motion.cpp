#include "worker/engine/scene/motion.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "common/math/tolerance.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine {
namespace {

constexpr size_t kVerticesPerTask = 1024;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

V2d RasterPosition(const RasterPoint& p) {
  return {p.x / p.w, p.y / p.w};
}

/// Distance of a raster position from the frame, 0 within.
double DistanceFromFrame(const FrameView& view, const V2d& p) {
  return std::hypot(std::max({0.0, -p.x, p.x - view.width}), std::max({0.0, -p.y, p.y - view.height}));
}

/// The length of a path through `points` in the raster; infinite if one of them is behind the near plane.
double PathLength(const RasterPoint* points, size_t count) {
  double length = 0;
  for (size_t i = 1; i < count; ++i) {
    if (points[i] == points[i - 1]) continue;
    if (!IsInFront(points[i]) || !IsInFront(points[i - 1])) return kInfinity;
    const V2d step = RasterPosition(points[i]) - RasterPosition(points[i - 1]);
    length += std::hypot(step.x, step.y);
  }
  return length;
}

/// The length of a vertex's path, from four places a curved piece.
double CurveLength(const RasterPoint* control_points, int degree, int pieces) {
  if (degree < 2) return PathLength(control_points, size_t(pieces * degree) + 1);
  constexpr int kSteps = 4;
  double length = 0;
  for (int piece = 0; piece < pieces; ++piece) {
    RasterPoint places[kSteps + 1];
    for (int i = 0; i <= kSteps; ++i) {
      places[i] = BezierPoint(control_points + piece * degree, degree, double(i) / kSteps);
    }
    length += PathLength(places, kSteps + 1);
  }
  return length;
}

/// A bound on how far a piece of a curve is from its chord at equal u: n (n - 1) / 8 times the largest second
/// difference of its control points, as seen in the raster. Depth counts too: a surface may come nearer and
/// go without moving in the picture.
double ChordPixels(const FrameView& view, const RasterPoint* c, int degree) {
  double largest = 0;
  for (int i = 1; i < degree; ++i) {
    const RasterPoint bend = (c[i + 1] - c[i]) - (c[i] - c[i - 1]);
    const PathError off = PathErrorBetween(view, c[i], c[i] + (degree * (degree - 1) / 8.0) * bend);
    largest = std::max({largest, off.pixels, off.depth * (kChordPixels / kPathDepth)});
  }
  return largest;
}

ControlPointFacts Merge(const ControlPointFacts& a, const ControlPointFacts& b) {
  return {a.all_usable && b.all_usable, std::max(a.motion_pixels, b.motion_pixels),
          std::max(a.chord_pixels, b.chord_pixels)};
}

}  // namespace

bool IsUsable(const RasterPoint& p) {
  // A comparison with NaN is false.
  return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
         std::abs(p.z) <= kMaxCoordinate && std::abs(p.w) <= kMaxCoordinate;
}

bool IsInFront(const RasterPoint& p) {
  return p.w > 0 && p.z <= p.w;
}

void WritePlaces(const FrameView& view, const MeshPrimitive& primitive, const MeshPose& pose,
                 std::span<const uint32_t> vertices, size_t index, size_t per_vertex,
                 std::span<RasterPoint> points) {
  const size_t count = vertices.empty() ? primitive.positions.size() : vertices.size();
  SL_CHECK(points.size() == count * per_vertex && index < per_vertex);
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, count, kVerticesPerTask), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          const uint32_t vertex = vertices.empty() ? uint32_t(i) : vertices[i];
          points[i * per_vertex + index] = view.RasterFromView(pose.Position(primitive, vertex));
        }
      });
}

bool AnyVertexMoves(const FrameView& view, const MeshPrimitive& primitive, const MeshPose& pose,
                    std::span<const RasterPoint> places) {
  for (uint32_t v = 0; v < places.size(); ++v) {
    const RasterPoint& a = places[v];
    const RasterPoint b = view.RasterFromView(pose.Position(primitive, v));
    // A vertex that becomes unusable half-way counts as moving, so that its triangles are dropped; one that
    // always is is dropped as it is.
    if (IsUsable(a) != IsUsable(b)) return true;
    if (!(a == b) && IsUsable(a)) return true;
  }
  return false;
}

void InterpolateBezier(std::span<RasterPoint> points) {
  if (points.size() == 3) {
    const RasterPoint &a = points[0], &b = points[2];
    points[1] = 2.0 * points[1] - 0.5 * (a + b);
  } else if (points.size() == 4) {
    const RasterPoint a = points[0], p = points[1], q = points[2], b = points[3];
    points[1] = p + (1.0 / 6) * ((5.0 * (p - a) + 2.0 * (b - p)) + 9.0 * (p - q));
    points[2] = q + (1.0 / 6) * ((5.0 * (q - b) + 2.0 * (a - q)) + 9.0 * (q - p));
  }
}

void InterpolateAll(int degree, int pieces, std::span<RasterPoint> points) {
  if (degree < 2) return;
  const size_t per_vertex = size_t(pieces * degree) + 1;
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, points.size() / per_vertex, kVerticesPerTask),
      [&](const tbb::blocked_range<size_t>& range) {
        for (size_t v = range.begin(); v < range.end(); ++v) {
          for (size_t piece = 0; piece < size_t(pieces); ++piece) {
            InterpolateBezier(points.subspan(v * per_vertex + piece * size_t(degree), size_t(degree) + 1));
          }
        }
      });
}

ControlPointFacts FactsOf(const FrameView& view, const MeshPrimitive& primitive, int degree, int pieces,
                          std::span<const RasterPoint> control_points) {
  const size_t count = primitive.positions.size();
  const size_t per_vertex = size_t(pieces * degree) + 1;
  SL_CHECK(control_points.size() == count * per_vertex);
  const std::vector<uint8_t> used = degree > 0 ? UsedVertices(primitive) : std::vector<uint8_t>();
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, count, kVerticesPerTask), ControlPointFacts(),
      [&](const tbb::blocked_range<size_t>& range, ControlPointFacts facts) {
        for (size_t v = range.begin(); v < range.end(); ++v) {
          const RasterPoint* const c = &control_points[v * per_vertex];
          const bool usable = std::all_of(c, c + per_vertex, IsUsable);
          facts.all_usable = facts.all_usable && usable;
          if (degree == 0 || !usable || !used[v]) continue;
          facts.motion_pixels = std::max(facts.motion_pixels, CurveLength(c, degree, pieces));
          for (int piece = 0; piece < pieces && degree > 1; ++piece) {
            facts.chord_pixels = std::max(facts.chord_pixels, ChordPixels(view, c + piece * degree, degree));
          }
        }
        return facts;
      },
      Merge);
}

int LinearPiecesFor(int degree, int pieces, double chord_pixels) {
  if (degree < 2) return pieces;
  int cuts = 1;  // The distance from the chord falls with the square of the cuts of a piece.
  while (pieces * cuts < kMaxLinearPieces && chord_pixels > kChordPixels * cuts * cuts) cuts *= 2;
  return pieces * cuts;
}

bool PathError::IsWithinTolerance() const {
  return pixels <= kPathPixels && depth <= kPathDepth;
}

double PathError::Excess() const {
  return std::max(pixels / kPathPixels, depth / kPathDepth);
}

void PathError::Extend(const PathError& other) {
  pixels = std::max(pixels, other.pixels);
  depth = std::max(depth, other.depth);
}

PathError PathErrorBetween(const FrameView& view, const RasterPoint& path, const RasterPoint& fit) {
  if (path == fit || !IsUsable(path) || !IsUsable(fit)) return {};
  PathError error{kInfinity, kInfinity};
  if (view.perspective) {
    const V3d place = view.ViewFromRaster(path);
    const double angle = (view.ViewFromRaster(fit) - place).length() / std::max(place.length(), view.znear);
    error = {std::max(view.scale_x, view.scale_y) * angle, angle};
    if (!IsInFront(path) || !IsInFront(fit)) return error;
  }
  const V2d a = RasterPosition(path), b = RasterPosition(fit);
  const double depth = view.perspective ? std::abs(path.w / fit.w - 1) : std::abs(path.z - fit.z);
  const PathError seen{std::hypot(a.x - b.x, a.y - b.y), depth};
  const double outside = std::min(DistanceFromFrame(view, a), DistanceFromFrame(view, b));
  if (outside == 0) return seen;
  const double size = std::hypot(view.width, view.height);
  const double share = size / (size + outside);
  return {std::min(error.pixels, seen.pixels * share), std::min(error.depth, seen.depth * share)};
}

PathError LargestPathError(const FrameView& view, const MeshPrimitive& primitive, const MeshPose& pose,
                           double t, int degree, int pieces, std::span<const uint8_t> used,
                           std::span<const uint32_t> vertices, std::span<const RasterPoint> points) {
  const size_t count = vertices.empty() ? primitive.positions.size() : vertices.size();
  const size_t per_vertex = size_t(pieces * degree) + 1;
  const CurvePosition at = CurvePositionAt(pieces, t);
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, count, kVerticesPerTask), PathError(),
      [&](const tbb::blocked_range<size_t>& range, PathError error) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          const uint32_t vertex = vertices.empty() ? uint32_t(i) : vertices[i];
          if (!used[vertex]) continue;
          const RasterPoint fit =
              BezierPoint(&points[i * per_vertex + size_t(at.piece * degree)], degree, at.u);
          error.Extend(PathErrorBetween(view, view.RasterFromView(pose.Position(primitive, vertex)), fit));
        }
        return error;
      },
      [](PathError a, const PathError& b) {
        a.Extend(b);
        return a;
      });
}

}  // namespace shutterline::engine
