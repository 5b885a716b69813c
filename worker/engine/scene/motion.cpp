#include "worker/engine/scene/motion.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "common/base/work_limit.h"
#include "common/math/tolerance.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine {
namespace {

constexpr size_t kVerticesPerTask = 1024;
constexpr size_t kVerticesPerPart = 256;
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

/// A bound that cannot be told from `exact` where it matters: enlarged by more than both were rounded.
double Enlarged(double length) {
  return length * (1 + 1e-9) + 1e-150;
}

/// As PathLength, but quickly, and rounded in another way.
double ApproximateLength(const RasterPoint* points, size_t count) {
  double length = 0;
  bool in_front = IsInFront(points[0]);
  V2d last = RasterPosition(points[0]);
  for (size_t i = 1; i < count; ++i) {
    const V2d next = RasterPosition(points[i]);
    in_front = in_front && IsInFront(points[i]);
    length += std::sqrt((next.x - last.x) * (next.x - last.x) + (next.y - last.y) * (next.y - last.y));
    last = next;
  }
  return in_front ? length : kInfinity;
}

/// The length of a vertex's path, from four places a curved piece; or anything that is not above `least`, if
/// it is not.
double CurveLength(const RasterPoint* control_points, int degree, int pieces, double least) {
  if (degree < 2) return PathLength(control_points, size_t(pieces * degree) + 1);
  constexpr int kSteps = 4;
  std::array<RasterPoint, kMaxMotionPieces*(kSteps + 1)> places;
  double about = 0;
  for (int piece = 0; piece < pieces; ++piece) {
    RasterPoint* const of_piece = &places[size_t(piece * (kSteps + 1))];
    for (int i = 0; i <= kSteps; ++i) {
      of_piece[i] = BezierPoint(control_points + piece * degree, degree, double(i) / kSteps);
    }
    about += ApproximateLength(of_piece, kSteps + 1);
  }
  if (Enlarged(about) <= least) return 0;
  double length = 0;
  for (int piece = 0; piece < pieces; ++piece) {
    length += PathLength(&places[size_t(piece * (kSteps + 1))], kSteps + 1);
  }
  return length;
}

/// A bound on how far a piece of a curve is from its chord at equal u: n (n - 1) / 8 times the largest second
/// difference of its control points, as seen in the raster from each of them, for what a difference comes to
/// there depends on place and w, and the curve is among them. Depth counts too: a surface may come nearer and
/// go without moving in the picture. Or anything that is not above `least`, if it is not.
double ChordPixels(const FrameView& view, const RasterPoint* c, int degree, double least) {
  double largest = 0;
  for (int i = 1; i < degree; ++i) {
    const RasterPoint bend = (degree * (degree - 1) / 8.0) * ((c[i + 1] - c[i]) - (c[i] - c[i - 1]));
    const bool keeps_depth = bend.z == 0 && bend.w == 0;
    for (int k = 0; k <= degree; ++k) {
      const RasterPoint both[] = {c[k], c[k] + bend};
      if (keeps_depth && Enlarged(ApproximateLength(both, 2)) <= least) continue;
      const PathError off = PathErrorBetween(view, both[0], both[1]);
      largest = std::max({largest, off.pixels, off.depth * (kChordPixels / kPathDepth)});
    }
  }
  return largest;
}

ControlPointFacts Merge(const ControlPointFacts& a, const ControlPointFacts& b) {
  return {a.all_usable && b.all_usable, std::max(a.motion_pixels, b.motion_pixels),
          std::max(a.chord_pixels, b.chord_pixels)};
}

/// Takes what the control points of vertices from number `first` on say.
void ExtendFacts(const FrameView& view, std::span<const uint8_t> used, uint32_t first, int degree, int pieces,
                 std::span<const RasterPoint> control_points, ControlPointFacts& facts) {
  const size_t per_vertex = size_t(pieces * degree) + 1;
  const size_t count = control_points.size() / per_vertex;
  for (size_t v = 0; v < count; ++v) {
    const RasterPoint* const c = &control_points[v * per_vertex];
    const bool usable = std::all_of(c, c + per_vertex, IsUsable);
    facts.all_usable = facts.all_usable && usable;
    if (degree == 0 || !usable || !used[first + v]) continue;
    if (degree > 1 || !(Enlarged(ApproximateLength(c, per_vertex)) <= facts.motion_pixels)) {
      facts.motion_pixels =
          std::max(facts.motion_pixels, CurveLength(c, degree, pieces, facts.motion_pixels));
    }
    for (int piece = 0; piece < pieces && degree > 1; ++piece) {
      facts.chord_pixels =
          std::max(facts.chord_pixels, ChordPixels(view, c + piece * degree, degree, facts.chord_pixels));
    }
  }
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

void WritePlaces(const FrameView& view, const MeshPrimitive& primitive, const MeshPose& pose, uint32_t first,
                 uint32_t count, size_t stride, RasterPoint* points) {
  const FrameView local = view;  // The compiler then knows that writing points does not change it.
  const M44d* const shared = pose.MatrixOf(primitive);
  if (shared == nullptr) {
    for (uint32_t i = 0; i < count; ++i) {
      points[i * stride] = local.RasterFromView(pose.Position(primitive, first + i));
    }
    return;
  }
  const M44d matrix = *shared;
  const V3f* const positions = primitive.positions.data() + first;
  for (uint32_t i = 0; i < count; ++i) {
    points[i * stride] = local.RasterFromView(TransformPoint(matrix, V3d(positions[i])));
  }
}

bool AnyVertexMoves(const FrameView& view, const MeshPrimitive& primitive, const MeshPose& a,
                    const MeshPose& b) {
  const M44d* const matrix_a = a.MatrixOf(primitive);
  const M44d* const matrix_b = b.MatrixOf(primitive);
  if (matrix_a != nullptr && matrix_b != nullptr && *matrix_a == *matrix_b) return false;
  for (uint32_t v = 0; v < primitive.positions.size(); ++v) {
    const RasterPoint at_a = view.RasterFromView(a.Position(primitive, v));
    const RasterPoint at_b = view.RasterFromView(b.Position(primitive, v));
    // A vertex that becomes unusable half-way counts as moving, so that its triangles are dropped; one that
    // always is is dropped as it is.
    if (IsUsable(at_a) != IsUsable(at_b)) return true;
    if (!(at_a == at_b) && IsUsable(at_a)) return true;
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

ControlPointFacts WriteCurves(const FrameView& view, const MeshPrimitive& primitive,
                              std::span<const uint8_t> used, std::span<const MeshPose* const> poses,
                              int degree, int pieces, std::span<RasterPoint> points) {
  const size_t per_vertex = size_t(pieces * degree) + 1;
  const WorkLimit* const limit = WorkLimit::Current();
  SL_CHECK(poses.size() == per_vertex && points.size() == primitive.positions.size() * per_vertex);
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, primitive.positions.size(), kVerticesPerTask), ControlPointFacts(),
      [&](const tbb::blocked_range<size_t>& range, ControlPointFacts facts) {
        // In parts that stay in the cache.
        for (size_t first = range.begin(); first < range.end(); first += kVerticesPerPart) {
          CheckWork(limit);
          const size_t count = std::min(kVerticesPerPart, range.end() - first);
          const std::span<RasterPoint> part = points.subspan(first * per_vertex, count * per_vertex);
          for (size_t i = 0; i < per_vertex; ++i) {
            WritePlaces(view, primitive, *poses[i], uint32_t(first), uint32_t(count), per_vertex, &part[i]);
          }
          for (size_t v = 0; v < count && degree > 1; ++v) {
            for (size_t piece = 0; piece < size_t(pieces); ++piece) {
              InterpolateBezier(part.subspan(v * per_vertex + piece * size_t(degree), size_t(degree) + 1));
            }
          }
          ExtendFacts(view, used, uint32_t(first), degree, pieces, part, facts);
        }
        return facts;
      },
      Merge);
}

ControlPointFacts FactsOf(const FrameView& view, const MeshPrimitive& primitive, int degree, int pieces,
                          std::span<const RasterPoint> control_points) {
  const size_t count = primitive.positions.size();
  const size_t per_vertex = size_t(pieces * degree) + 1;
  SL_CHECK(control_points.size() == count * per_vertex);
  const std::vector<uint8_t> used = degree > 0 ? UsedVertices(primitive) : std::vector<uint8_t>();
  ControlPointFacts facts;
  ExtendFacts(view, used, 0, degree, pieces, control_points, facts);
  return facts;
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

bool IsSurelyWithinTolerance(const FrameView& view, const RasterPoint& path, const RasterPoint& fit) {
  if (!IsInFront(path) || !IsInFront(fit)) return false;
  // Both positions times both distances; far outside of the frame rounding is not small.
  constexpr double kSlack = 0.999, kFar = 1e6;
  const double w = path.w * fit.w;
  const double x = path.x * fit.w - fit.x * path.w;
  const double y = path.y * fit.w - fit.y * path.w;
  const double most = kSlack * kPathPixels * w;
  const bool is_deep = view.perspective ? std::abs(path.w - fit.w) <= kSlack * kPathDepth * fit.w
                                        : std::abs(path.z - fit.z) <= kSlack * kPathDepth;
  // Of tiny numbers the squares would vanish.
  return w > 1e-100 && is_deep && x * x + y * y <= most * most && std::abs(path.x) <= kFar * path.w &&
         std::abs(path.y) <= kFar * path.w;
}

}  // namespace shutterline::engine
