#include "worker/engine/accel/triangle_refs.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "common/base/work_limit.h"
#include "common/job/tile.h"
#include "common/math/bezier.h"

namespace shutterline::engine {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
/// Cutting once more must leave no more than this share of the area.
constexpr double kWorthwhile = 0.9;
/// Pixels added to a box when boxes are compared. A box reaches tiles as if it were a tile longer; but boxes
/// of neighbouring spans reach the same.
constexpr double kBorder = kTileSize / 2.0;
/// Sums of bounds must not overflow. Scaled coordinates stay below 2^21.
constexpr float kLargest = 0x1p60f;
/// Triangles or vertices that a task looks at, at least.
constexpr uint32_t kTask = 2048;

/// The nearest float not above (not below) `value`, which is not NaN.
float RoundDown(double value) {
  const float f = float(std::clamp(value, -double(kLargest), double(kLargest)));
  if (!(double(f) > value)) return f;
  // Floats are ordered as their bits are, but for the sign.
  const uint32_t bits = std::bit_cast<uint32_t>(f);
  if (f == 0) return -std::numeric_limits<float>::denorm_min();
  return std::bit_cast<float>(f > 0 ? bits - 1 : bits + 1);
}
float RoundUp(double value) {
  return -RoundDown(-value);
}

/// How far ViewFromRaster(p) may be from the exact view-space point: roundings of its terms and of the hull's
/// own points.
V3d InverseError(const FrameView& view, const RasterPoint& p) {
  constexpr double kRoundings = 16 * std::numeric_limits<double>::epsilon();
  return kRoundings * V3d((std::abs(p.x) + std::abs(view.center_x * p.w)) / std::abs(view.scale_x),
                          (std::abs(p.y) + std::abs(view.center_y * p.w)) / std::abs(view.scale_y),
                          view.perspective ? std::abs(p.w)
                                           : std::abs(view.zfar) + std::abs(p.z * (view.zfar - view.znear)));
}

/// Bounds of points in view space, grown point by point.
class PointBounds {
 public:
  PointBounds(const FrameView& view, double scale) : view_(view), scale_(scale) {}

  void Extend(const RasterPoint& point) {
    const V3d p = view_.ViewFromRaster(point);
    const V3d error = InverseError(view_, point);
    for (int axis = 0; axis < 3; ++axis) {
      lower_[axis] = std::min(lower_[axis], p[axis] - error[axis]);
      upper_[axis] = std::max(upper_[axis], p[axis] + error[axis]);
    }
  }

  /// In units of the scale, rounded outwards.
  ViewBounds Rounded() const {
    ViewBounds bounds;
    for (int axis = 0; axis < 3; ++axis) {
      bounds.lower[size_t(axis)] = RoundDown(lower_[axis] / scale_);
      bounds.upper[size_t(axis)] = RoundUp(upper_[axis] / scale_);
    }
    return bounds;
  }

 private:
  const FrameView& view_;
  const double scale_;
  V3d lower_{kFar}, upper_{-kFar};
};

/// Hands a reference's hull (AppendHull) to `take`, point by point.
template <typename Take>
void ForEachHullPoint(const FrameScene& frame, const TriangleRef& ref, Take take) {
  const FrameTriangle& triangle = frame.triangles[ref.triangle];
  const FramePrimitive& primitive = frame.primitives[triangle.primitive];
  for (const uint32_t vertex : triangle.vertices) {
    const RasterPoint* c = frame.ControlPoints(primitive, vertex);
    if (ref.spans <= primitive.pieces) {
      const int count = primitive.pieces / ref.spans * primitive.degree;
      for (int i = ref.span * count; i <= (ref.span + 1) * count; ++i) take(c[i]);
      continue;
    }
    const int per_piece = ref.spans / primitive.pieces;
    const int part = ref.span % per_piece;
    RasterPoint cut[kMaxBezierDegree + 1];
    BezierPart(c + ref.span / per_piece * primitive.degree, primitive.degree, double(part) / per_piece,
               double(part + 1) / per_piece, cut);
    for (int i = 0; i <= primitive.degree; ++i) take(cut[i]);
  }
}

struct RasterExtent {
  V2d low{kFar}, high{-kFar};

  void Extend(const V2d& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  void Extend(const RasterExtent& other) {
    Extend(other.low);
    Extend(other.high);
  }
};

/// Decides how finely the triangles of one primitive are cut. Neighbours share vertices, so what was found of
/// the latest vertices is remembered.
class SpanChooser {
 public:
  SpanChooser(const FrameScene& frame, const FramePrimitive& primitive)
      : frame_(frame), primitive_(primitive), hulls_(kRemembered), sweeps_(kRemembered) {}

  int SpansFor(const FrameTriangle& triangle) {
    // Spans of a box of area A and half-perimeter L have boxes of L and N borders' squares together at least.
    RasterExtent all;
    bool is_known = true;
    for (const uint32_t vertex : triangle.vertices) {
      const Hull& hull = HullOf(vertex);
      is_known = is_known && hull.is_known;
      all.Extend(hull.extent);
    }
    constexpr double kTooSmall = 1.2 * kBorder * kBorder;
    static_assert(1 + 1.2 < 2 / kWorthwhile);
    if (is_known && (all.high.x - all.low.x) * (all.high.y - all.low.y) < kTooSmall) return 1;

    // Boxes of the shortest spans, then of two joined, and so on.
    std::array<RasterExtent, kMaxRefSpans + 1> boxes;
    for (const uint32_t vertex : triangle.vertices) {
      const Sweep& sweep = SweepOf(vertex);
      if (!sweep.is_in_front) return 1;
      for (size_t i = 0; i < boxes.size(); ++i) boxes[i].Extend(sweep.places[i]);
    }
    for (size_t i = 0; i < kMaxRefSpans; ++i) boxes[i].Extend(boxes[i + 1]);
    std::array<double, kMaxRefSpansLog2 + 1> areas;
    for (int log2 = kMaxRefSpansLog2; log2 >= 0; --log2) {
      double area = 0;
      for (size_t i = 0; i < size_t{1} << log2; ++i) {
        const RasterExtent& box = boxes[i];
        area += (box.high.x - box.low.x + kBorder) * (box.high.y - box.low.y + kBorder);
      }
      areas[size_t(log2)] = area;
      for (size_t i = 0; 2 * i < size_t{1} << log2; ++i) {
        boxes[i] = boxes[2 * i];
        if (log2 > 0) boxes[i].Extend(boxes[2 * i + 1]);
      }
    }
    int best = 1;
    double least = areas[0], price = 1;
    for (int log2 = 1; log2 <= kMaxRefSpansLog2; ++log2) {
      price /= kWorthwhile;
      const double cost = price * areas[size_t(log2)];
      if (cost >= least) continue;
      least = cost;
      best = 1 << log2;
    }
    return best;
  }

 private:
  static constexpr size_t kRemembered = 256;
  static constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

  /// Of a vertex's control points in the raster; known where all are in front of the eye.
  struct Hull {
    uint32_t vertex = kNone;
    bool is_known = true;
    RasterExtent extent;
  };
  /// A vertex's places at equal steps of the shutter, in the raster, unless one is behind the near plane.
  struct Sweep {
    uint32_t vertex = kNone;
    bool is_in_front = true;
    std::array<V2d, kMaxRefSpans + 1> places;
  };

  const Hull& HullOf(uint32_t vertex) {
    Hull& hull = hulls_[vertex % kRemembered];
    if (hull.vertex == vertex) return hull;
    hull = Hull();
    hull.vertex = vertex;
    const RasterPoint* points = frame_.ControlPoints(primitive_, vertex);
    for (int i = 0; i < primitive_.PointsPerVertex(); ++i) {
      const RasterPoint& p = points[i];
      hull.is_known = hull.is_known && p.w > 0;
      hull.extent.Extend(V2d(p.x / p.w, p.y / p.w));
    }
    return hull;
  }

  const Sweep& SweepOf(uint32_t vertex) {
    Sweep& sweep = sweeps_[vertex % kRemembered];
    if (sweep.vertex == vertex) return sweep;
    sweep.vertex = vertex;
    sweep.is_in_front = true;
    for (int i = 0; i <= kMaxRefSpans && sweep.is_in_front; ++i) {
      const RasterPoint p = frame_.VertexAt(primitive_, vertex, double(i) / kMaxRefSpans);
      sweep.is_in_front = p.w > 0 && p.z <= p.w;
      sweep.places[size_t(i)] = {p.x / p.w, p.y / p.w};
    }
    return sweep;
  }

  const FrameScene& frame_;
  const FramePrimitive& primitive_;
  std::vector<Hull> hulls_;
  std::vector<Sweep> sweeps_;
};

/// The primitive's fastest corner does not cross two tiles: no box is long.
bool IsSlow(const FramePrimitive& primitive) {
  return primitive.degree == 0 || primitive.motion_pixels < 2 * kTileSize;
}

/// Calls `f(begin, end)`, in parallel, with parts of the triangles of a primitive.
template <typename F>
void ForTriangles(const FramePrimitive& primitive, F f) {
  const WorkLimit* const limit = WorkLimit::Current();
  const uint32_t end = primitive.first_triangle + primitive.triangle_count;
  tbb::parallel_for(tbb::blocked_range<uint32_t>(primitive.first_triangle, end, kTask),
                    [&](const tbb::blocked_range<uint32_t>& part) {
                      CheckWork(limit);
                      f(part.begin(), part.end());
                    });
}

/// Bounds of the triangles of a primitive over the whole shutter, where vertices are shared: each vertex is
/// looked at once. Rounding keeps the order of numbers, so they are those of BoundsOf.
class VertexBounds {
 public:
  VertexBounds(const FrameScene& frame, const FramePrimitive& primitive, double scale)
      : first_(primitive.first_vertex), bounds_(primitive.vertex_count) {
    tbb::parallel_for(tbb::blocked_range<uint32_t>(0, primitive.vertex_count, kTask),
                      [&](const tbb::blocked_range<uint32_t>& part) {
                        for (uint32_t v = part.begin(); v < part.end(); ++v) {
                          PointBounds bounds(frame.view, scale);
                          const RasterPoint* points = frame.ControlPoints(primitive, first_ + v);
                          for (int i = 0; i < primitive.PointsPerVertex(); ++i) bounds.Extend(points[i]);
                          bounds_[v] = bounds.Rounded();
                        }
                      });
  }

  ViewBounds Of(const FrameTriangle& triangle) const {
    ViewBounds all = bounds_[triangle.vertices[0] - first_];
    for (size_t k = 1; k < 3; ++k) {
      const ViewBounds& corner = bounds_[triangle.vertices[k] - first_];
      for (size_t axis = 0; axis < 3; ++axis) {
        all.lower[axis] = std::min(all.lower[axis], corner.lower[axis]);
        all.upper[axis] = std::max(all.upper[axis], corner.upper[axis]);
      }
    }
    return all;
  }

 private:
  const uint32_t first_;
  std::vector<ViewBounds> bounds_;
};

}  // namespace

void AppendHull(const FrameScene& frame, const TriangleRef& ref, std::vector<RasterPoint>& points) {
  ForEachHullPoint(frame, ref, [&](const RasterPoint& point) { points.push_back(point); });
}

int SpansFor(const FrameScene& frame, uint32_t triangle) {
  const FrameTriangle& corners = frame.triangles[triangle];
  const FramePrimitive& primitive = frame.primitives[corners.primitive];
  return IsSlow(primitive) ? 1 : SpanChooser(frame, primitive).SpansFor(corners);
}

ViewBounds BoundsOf(const FrameScene& frame, const TriangleRef& ref, double scale) {
  PointBounds bounds(frame.view, scale);
  ForEachHullPoint(frame, ref, [&](const RasterPoint& point) { bounds.Extend(point); });
  return bounds.Rounded();
}

BoundedRefs MakeBoundedRefs(const FrameScene& frame, double scale) {
  const WorkLimit* const limit = WorkLimit::Current();
  // Count the references before each triangle.
  std::vector<uint32_t> first_ref(frame.triangles.size() + 1, 1);
  tbb::parallel_for(size_t{0}, frame.primitives.size(), [&](size_t p) {
    const WorkLimitScope scope(limit);
    const FramePrimitive& primitive = frame.primitives[p];
    if (IsSlow(primitive)) return;
    ForTriangles(primitive, [&](uint32_t begin, uint32_t end) {
      SpanChooser chooser(frame, primitive);
      for (uint32_t i = begin; i < end; ++i) first_ref[i] = uint32_t(chooser.SpansFor(frame.triangles[i]));
    });
  });
  uint64_t total = 0;
  for (uint32_t i = 0; i < frame.triangles.size(); ++i) total += first_ref[i];
  // References are numbered by 32 bits as triangles are: a frame that huge is not cut at all.
  const bool cut = total < std::numeric_limits<uint32_t>::max();
  uint32_t before = 0;
  for (uint32_t& first : first_ref) {
    const uint32_t spans = cut ? first : 1;
    first = before;
    before += spans;
  }

  // Write them.
  BoundedRefs result;
  result.refs.resize(first_ref.back());
  result.bounds.resize(first_ref.back());
  tbb::parallel_for(size_t{0}, frame.primitives.size(), [&](size_t p) {
    const WorkLimitScope scope(limit);
    const FramePrimitive& primitive = frame.primitives[p];
    std::optional<VertexBounds> vertices;
    if (primitive.vertex_count <= 3 * uint64_t{primitive.triangle_count}) {
      vertices.emplace(frame, primitive, scale);
    }
    ForTriangles(primitive, [&](uint32_t begin, uint32_t end) {
      for (uint32_t i = begin; i < end; ++i) {
        const uint32_t first = first_ref[i];
        const uint8_t spans = uint8_t(first_ref[i + 1] - first);
        for (uint8_t span = 0; span < spans; ++span) {
          const TriangleRef ref = result.refs[first + span] = {i, span, spans};
          result.bounds[first + span] =
              spans == 1 && vertices ? vertices->Of(frame.triangles[i]) : BoundsOf(frame, ref, scale);
        }
      }
    });
  });
  return result;
}

}  // namespace shutterline::engine
