#include "worker/engine/stochastic/cell_setup.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace shutterline::engine {
namespace {

/// Depths are rounded a few times in single precision before they are compared with a bound.
constexpr double kNearestSlack = 1 + 4e-6;

/// A vertex relative to a cell on a piece of its motion, as powers of the piece's time u.
struct MovingVertex {
  uint32_t number = 0;
  int degree = 0;
  double scale = 1;
  std::array<RasterPoint, kMaxMotionDegree + 1> power{};
};

/// A power of two that brings `magnitude` between 1 and 2 (or near, at the ends of the range).
double ScaleOf(double magnitude) {
  const auto exponent = std::bit_cast<uint64_t>(magnitude) >> 52 & 0x7ff;
  return std::bit_cast<double>((2046 - std::min<uint64_t>(exponent, 2045)) << 52);
}

/// From Bezier control points to powers of u.
void MakeMonomials(const RasterPoint* c, int degree, MovingVertex& v) {
  v.power[0] = c[0];
  v.degree = 0;
  // A resting vertex stays bit for bit what it is.
  if (std::all_of(c + 1, c + degree + 1, [&](const RasterPoint& p) { return p == c[0]; })) return;
  v.degree = degree;
  switch (degree) {
    case 1:
      v.power[0] = 0.5 * (c[0] + c[1]);
      v.power[1] = 0.5 * (c[1] - c[0]);
      break;
    case 2:
      v.power[0] = 0.25 * (c[0] + c[2] + 2 * c[1]);
      v.power[1] = 0.5 * (c[2] - c[0]);
      v.power[2] = 0.25 * (c[0] + c[2] - 2 * c[1]);
      break;
    default:
      v.power[0] = 0.125 * (c[0] + c[3] + 3 * (c[1] + c[2]));
      v.power[1] = 0.375 * (c[3] - c[0] + (c[2] - c[1]));
      v.power[2] = 0.375 * (c[0] + c[3] - (c[1] + c[2]));
      v.power[3] = 0.125 * (c[3] - c[0] - 3 * (c[2] - c[1]));
  }
}

class CellSetup {
 public:
  CellSetup(const FrameScene& frame, int x, int y, CellTriangles& cell)
      : frame_(frame), x_(x), y_(y), cell_(cell) {}

  void Add(uint32_t id, const PrimitiveTraits& traits);
  void Finish();

 private:
  void AddPiece(CellTriangle triangle, const FramePrimitive& primitive, int piece, bool rests,
                const PrimitiveTraits& traits);
  void PlaceVertex(const FramePrimitive& primitive, uint32_t number, int piece, int degree, int k);
  void AddCoefficients(CellTriangle& triangle);
  void AddEdge(const MovingVertex& lo, const MovingVertex& hi, int degree);
  bool Measure(CellTriangle& triangle, int degree);

  const FrameScene& frame_;
  double x_, y_;
  CellTriangles& cell_;
  std::array<MovingVertex, 3> vertices_;
  /// Control points of the three vertices relative to the cell, scaled.
  std::array<std::array<RasterPoint, kMaxMotionDegree + 1>, 3> controls_;
};

void CellSetup::PlaceVertex(const FramePrimitive& primitive, uint32_t number, int piece, int degree, int k) {
  constexpr double kUnit = 1.0 / kCellSize;
  std::array<RasterPoint, kMaxMotionDegree + 1>& c = controls_[size_t(k)];
  double magnitude = 0;
  const RasterPoint* const points = frame_.ControlPoints(primitive, number) + piece * primitive.degree;
  for (int i = 0; i <= degree; ++i) {
    const RasterPoint& p = points[i];
    c[size_t(i)] = {(p.x - x_ * p.w) * kUnit, (p.y - y_ * p.w) * kUnit, p.z, p.w};
    magnitude =
        std::max({magnitude, std::abs(c[size_t(i)].x), std::abs(c[size_t(i)].y), std::abs(c[size_t(i)].w)});
  }
  MovingVertex& v = vertices_[size_t(k)];
  v.number = number;
  v.scale = ScaleOf(magnitude);
  for (int i = 0; i <= degree; ++i) c[size_t(i)] = v.scale * c[size_t(i)];
  MakeMonomials(c.data(), degree, v);
  for (int i = v.degree + 1; i <= degree; ++i) v.power[size_t(i)] = {};
}

/// det((x, y, 1), lo, hi) by powers of u.
void CellSetup::AddEdge(const MovingVertex& lo, const MovingVertex& hi, int degree) {
  for (int power = 0; power <= 2 * degree; ++power) {
    double a = 0, b = 0, c = 0;
    for (int i = std::max(0, power - degree); i <= std::min(power, degree); ++i) {
      const RasterPoint& p = lo.power[size_t(i)];
      const RasterPoint& q = hi.power[size_t(power - i)];
      a += p.y * q.w - p.w * q.y;
      b += p.w * q.x - p.x * q.w;
      c += p.x * q.y - p.y * q.x;
    }
    cell_.coefficients.insert(cell_.coefficients.end(), {float(a), float(b), float(c)});
  }
}

void CellSetup::AddCoefficients(CellTriangle& triangle) {
  std::vector<float>& out = cell_.coefficients;
  triangle.first_coefficient = out.size();
  const int degree = triangle.degree;
  for (int k = 0; k < 3; ++k) {
    const MovingVertex& i = vertices_[size_t((k + 1) % 3)];
    const MovingVertex& j = vertices_[size_t((k + 2) % 3)];
    // Fronts run clockwise in raster space, whose y points down: their functions are negative.
    const bool ordered = i.number < j.number;
    triangle.edge_signs[size_t(k)] = ordered ? 0x80000000u : 0;
    AddEdge(ordered ? i : j, ordered ? j : i, degree);
  }
  const double largest = std::max({vertices_[0].scale, vertices_[1].scale, vertices_[2].scale});
  for (size_t k = 0; k < 3; ++k) triangle.barycentric_scale[k] = float(vertices_[k].scale / largest);
  if (degree == 0) {
    const auto& [p0, p1, p2] = vertices_;
    const RasterPoint &a = p0.power[0], &b = p1.power[0], &c = p2.power[0];
    const double det =
        a.x * (b.y * c.w - b.w * c.y) - a.y * (b.x * c.w - b.w * c.x) + a.w * (b.x * c.y - b.y * c.x);
    // Edge functions turned to the front have the sign of -det.
    for (const RasterPoint* p : {&a, &b, &c}) out.push_back(float(p->z / -det));
    return;
  }
  for (const MovingVertex& v : vertices_) {
    for (int i = 0; i <= degree; ++i) out.push_back(float(v.power[size_t(i)].w));
  }
  for (const MovingVertex& v : vertices_) {
    for (int i = 0; i <= degree; ++i) out.push_back(float(v.power[size_t(i)].z));
    for (int i = 1; i <= degree; ++i) cell_.constant_z &= v.power[size_t(i)].z == 0;
  }
}

/// Depth bound, and the rough measures by which passes are cut. False if it is never in the cell.
bool CellSetup::Measure(CellTriangle& triangle, int degree) {
  double nearest = 0, reach = 0, path_x = 0, path_y = 0;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double x0 = kInfinity, x1 = -x0, y0 = x0, y1 = -x0;                  // At the piece's begin.
  double left = kInfinity, right = -left, top = left, bottom = -left;  // Of the whole path.
  bool in_front = true;
  for (const auto& c : controls_) {
    double open_x = 0, open_y = 0;
    for (int i = 0; i <= degree; ++i) {
      const RasterPoint& p = c[size_t(i)];
      reach = std::max({reach, std::abs(p.x), std::abs(p.y)});
      if (!(p.w > 0) || p.z > p.w) {
        in_front = false;
        continue;
      }
      const double inverse = 1 / p.w, x = p.x * inverse, y = p.y * inverse;
      nearest = std::max(nearest, p.z * inverse);
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
      if (i == 0) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y);
        open_x = x;
        open_y = y;
      } else {
        path_x = std::max(path_x, std::abs(x - open_x));
        path_y = std::max(path_y, std::abs(y - open_y));
      }
    }
  }
  constexpr double kSlack = 1e-4;
  if (in_front && (right < -kSlack || left > 1 + kSlack || bottom < -kSlack || top > 1 + kSlack))
    return false;
  triangle.nearest_depth = in_front ? float(std::min(1.0, nearest * kNearestSlack)) : 1;
  cell_.reach.push_back(float(reach));
  const double all = 2;  // In cells: more is not to be told apart.
  const auto pixels = [&](double cells) { return float(kCellSize * std::min(cells, all)); };
  cell_.extent.push_back(in_front
                             ? std::array{pixels(x1 - x0), pixels(y1 - y0), pixels(path_x), pixels(path_y)}
                             : std::array{pixels(all), pixels(all), pixels(all), pixels(all)});
  return true;
}

void CellSetup::Add(uint32_t id, const PrimitiveTraits& traits) {
  const FrameTriangle& source = frame_.triangles[id];
  const FramePrimitive& primitive = frame_.primitives[source.primitive];
  const CellTriangle triangle{
      .id = id, .cull_back = traits.cull_back, .needs_position = traits.needs_position};
  // A triangle at rest in a moving primitive is at rest: it pays nothing for time.
  bool rests = true;
  for (const uint32_t number : source.vertices) {
    const RasterPoint* const points = frame_.ControlPoints(primitive, number);
    for (int i = 1; i < primitive.PointsPerVertex(); ++i) rests = rests && points[i] == points[0];
  }
  for (int piece = 0; piece < (rests ? 1 : primitive.pieces); ++piece) {
    AddPiece(triangle, primitive, piece, rests, traits);
  }
}

void CellSetup::AddPiece(CellTriangle triangle, const FramePrimitive& primitive, int piece, bool rests,
                         const PrimitiveTraits& traits) {
  const int degree = rests ? 0 : primitive.degree;
  triangle.degree = uint8_t(degree);
  if (!rests) {
    // The piece is t in [piece, piece + 1] / pieces.
    triangle.partial = primitive.pieces > 1;
    triangle.time_scale = float(primitive.pieces);
    triangle.time_offset = float(primitive.pieces - 2 * piece - 1);
  }
  const FrameTriangle& source = frame_.triangles[triangle.id];
  for (int k = 0; k < 3; ++k) PlaceVertex(primitive, source.vertices[size_t(k)], piece, degree, k);
  if (!Measure(triangle, degree)) return;
  cell_.degree = std::max(cell_.degree, degree);
  AddCoefficients(triangle);
  if (traits.textured && degree > 0) {
    // A texture that moves under a pixel is blurred by shading it at several times.
    constexpr int kMost = 6;
    while (triangle.shading_bins_log2 < kMost &&
           double(1 << triangle.shading_bins_log2) < primitive.motion_pixels) {
      ++triangle.shading_bins_log2;
    }
  }
  cell_.triangles.push_back(triangle);
  for (const MovingVertex& v : vertices_) {
    for (int i = 0; i <= kMaxMotionDegree; ++i) {
      const RasterPoint& p = v.power[size_t(i)];
      const bool used = i <= degree;
      cell_.path.insert(cell_.path.end(),
                        {used ? float(p.x) : 0, used ? float(p.y) : 0, used ? float(p.w) : 0});
    }
  }
}

/// Sorts by depth and turns the paths from one triangle after another into one array a coefficient.
void CellSetup::Finish() {
  const size_t count = cell_.triangles.size();
  // Nearest first: roughly is enough, so by the leading bits of a positive float and stably.
  constexpr int kShift = 19;
  std::vector<uint32_t> first((0x3f800000u >> kShift) + 3, 0);
  const auto bucket = [&](const CellTriangle& t) {
    return (0x3f800000u >> kShift) - (std::bit_cast<uint32_t>(t.nearest_depth) >> kShift);
  };
  for (const CellTriangle& t : cell_.triangles) ++first[bucket(t) + 1];
  for (size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<CellTriangle> sorted(count);
  std::vector<float> reach(count), path;
  std::vector<std::array<float, 4>> extent(count);
  cell_.stride = (count + kVectorSamples - 1) / kVectorSamples * kVectorSamples;
  path.assign(size_t(9 * (cell_.degree + 1)) * cell_.stride, 0);
  reach.resize(cell_.stride);
  std::vector<float> scale(cell_.stride, 1), offset(cell_.stride, 0);
  constexpr size_t kNumbers = size_t{9} * (kMaxMotionDegree + 1);
  for (size_t i = 0; i < count; ++i) {
    const size_t to = first[bucket(cell_.triangles[i])]++;
    sorted[to] = cell_.triangles[i];
    reach[to] = cell_.reach[i];
    scale[to] = sorted[to].time_scale;
    offset[to] = sorted[to].time_offset;
    extent[to] = cell_.extent[i];
    const float* from = cell_.path.data() + i * kNumbers;
    for (int vertex = 0; vertex < 3; ++vertex) {
      for (int power = 0; power <= cell_.degree; ++power) {
        for (int axis = 0; axis < 3; ++axis) {
          path[size_t((vertex * 3 + axis) * (cell_.degree + 1) + power) * cell_.stride + to] =
              from[(vertex * (kMaxMotionDegree + 1) + power) * 3 + axis];
        }
      }
    }
  }
  cell_.triangles.swap(sorted);
  cell_.reach.swap(reach);
  cell_.time_scale.swap(scale);
  cell_.time_offset.swap(offset);
  cell_.extent.swap(extent);
  cell_.path.swap(path);
}

}  // namespace

void SetUpCell(const FrameScene& frame, std::span<const PrimitiveTraits> traits, int x, int y,
               std::span<const uint32_t> candidates, CellTriangles& cell) {
  cell.degree = 0;
  cell.constant_z = true;
  cell.far_depth = float(frame.view.FarDepth());
  cell.triangles.clear();
  cell.coefficients.clear();
  cell.path.clear();
  cell.reach.clear();
  cell.extent.clear();
  CellSetup setup(frame, x, y, cell);
  for (const uint32_t id : candidates) setup.Add(id, traits[frame.triangles[id].primitive]);
  setup.Finish();
}

}  // namespace shutterline::engine
