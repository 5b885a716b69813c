#include "tests/fuzz/hostile_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/fuzz/hostile_values.h"
#include "tests/support/frame_scene_builder.h"

namespace shutterline::engine {
namespace {

constexpr int kSide = 16;

struct Motion {
  int degree = 0, pieces = 1;

  int Points() const { return degree * pieces + 1; }
};

/// A mesh to be: control points, a vertex's in a row, and its triangles.
struct HostileMesh {
  Motion motion;
  std::vector<RasterPoint> points = {};
  std::vector<std::array<uint32_t, 3>> triangles = {};
};

Motion AnyMotion(HostileValues& values) {
  const int degree = values.Int(0, 3);
  return {degree, degree == 0 ? 1 : 1 << values.Int(0, 2)};
}

TileRect AnyRect(HostileValues& values) {
  if (values.Chance(0.6)) return {0, 0, kSide, kSide};
  return {values.Int(0, 1024) * kSide, values.Int(0, 1024) * kSide, values.Int(1, kSide),
          values.Int(1, kSide)};
}

FlatLook AnyLook(HostileValues& values, size_t vertices) {
  FlatLook look{.color = V3f(float(values.Unit()), float(values.Unit()), float(values.Unit())),
                .double_sided = values.Chance(0.7)};
  if (values.Chance(0.5)) {
    for (size_t i = 0; i < vertices; ++i) {
      look.vertex_colors.push_back(V4f(float(values.Unit()), float(values.Unit()), float(values.Unit()), 1));
    }
  }
  return look;
}

/// Strips, fans, and any three vertices, equal ones among them.
std::vector<std::array<uint32_t, 3>> AnyTriangles(HostileValues& values, uint32_t vertices) {
  std::vector<std::array<uint32_t, 3>> triangles = {};
  const int kind = values.Int(0, 2);
  for (uint32_t i = 2; i < vertices; ++i) {
    if (kind == 0) triangles.push_back({i - 2, i - 1, i});
    if (kind == 1) triangles.push_back({0, i - 1, i});
    if (kind == 2) {
      triangles.push_back({uint32_t(values.Index(vertices)), uint32_t(values.Index(vertices)),
                           uint32_t(values.Index(vertices))});
    }
  }
  if (values.Chance(0.2)) triangles.push_back({triangles[0][1], triangles[0][2], triangles[0][0]});
  return triangles;
}

/// A point that appears at (x, y) of the tile, cut to what a frame may hold.
RasterPoint Point(const TileRect& rect, double x, double y, double z, double w) {
  const auto cut = [](double v) { return std::clamp(v, -kMaxCoordinate, kMaxCoordinate); };
  return {cut((x + rect.x) * w), cut((y + rect.y) * w), z, cut(w)};
}

RasterPoint AnyPoint(HostileValues& values, const TileRect& rect, double near) {
  const double x = values.Position(kSide);
  const double y = values.Position(kSide);
  RasterPoint p = Point(rect, x, y, near, values.W(near));
  // Coordinates that do not follow w: what passes by the camera.
  if (values.Chance(0.1)) p.x = x;
  if (values.Chance(0.1)) p.y = y;
  return p;
}

HostileMesh AnyMesh(HostileValues& values, const TileRect& rect, double near) {
  HostileMesh mesh{.motion = AnyMotion(values)};
  const auto vertices = uint32_t(values.Int(3, 8));
  const bool common_w = values.Chance(0.5);
  const double w = values.WInFront(near);
  const bool drifts = values.Chance(0.4);
  const double dx = values.Position(kSide) / 8;
  const double dy = values.Position(kSide) / 8;
  for (uint32_t v = 0; v < vertices; ++v) {
    const bool rests = values.Chance(0.2);
    const double x = values.Position(kSide);
    const double y = values.Position(kSide);
    RasterPoint first = AnyPoint(values, rect, near);
    if (common_w) first = Point(rect, x, y, near, w);
    for (int i = 0; i < mesh.motion.Points(); ++i) {
      RasterPoint p = first;
      if (i > 0 && !rests) {
        if (drifts && common_w) {
          p = Point(rect, x + i * dx, y + i * dy, near, w);
        } else if (values.Chance(0.8)) {
          p = AnyPoint(values, rect, near);
        }
      }
      mesh.points.push_back(p);
    }
  }
  mesh.triangles = AnyTriangles(values, vertices);
  return mesh;
}

void AddTo(FrameSceneBuilder& builder, const HostileMesh& mesh, const FlatLook& look) {
  builder.AddCurvedMesh(mesh.points, mesh.motion.degree, mesh.motion.pieces, mesh.triangles, look);
}

}  // namespace

HostileFrame AnyBits(uint64_t seed) {
  HostileValues values(seed);
  const TileRect rect = AnyRect(values);
  FrameView view = PerspectiveView(kSide, kSide);
  view.width = rect.x + kSide;
  view.height = rect.y + kSide;
  view.znear = values.Chance(0.7) ? 0.1 : std::clamp(std::abs(values.AnyMagnitude()), kLeastNear, 1e6);
  if (values.Chance(0.2)) view.zfar = std::max(view.znear * 2, 20 * values.Unit());
  FrameSceneBuilder builder(view);
  std::vector<HostileMesh> meshes;
  const int count = values.Int(1, 10);
  for (int i = 0; i < count; ++i) {
    if (!meshes.empty() && values.Chance(0.25)) {
      // A copy of another, perhaps with its triangles turned, or moved in depth by an ulp.
      HostileMesh copy = meshes[values.Index(meshes.size())];
      if (values.Chance(0.5)) {
        for (auto& t : copy.triangles) std::swap(t[0], t[2]);
      } else if (values.Chance(0.5)) {
        for (RasterPoint& p : copy.points) p.w = std::nextafter(p.w, values.Chance(0.5) ? 1e300 : -1e300);
      }
      meshes.push_back(copy);
    } else {
      meshes.push_back(AnyMesh(values, rect, view.znear));
    }
    const HostileMesh& mesh = meshes.back();
    AddTo(builder, mesh, AnyLook(values, mesh.points.size() / size_t(mesh.motion.Points())));
  }
  return {builder.Build(), rect};
}

HostileFrame OnLattice(uint64_t seed) {
  HostileValues values(seed);
  const TileRect rect{values.Chance(0.5) ? 0 : 48, values.Chance(0.5) ? 0 : 16, kSide, kSide};
  FrameView view = OrthographicView(64, 64, 1, 0, 1);
  FrameSceneBuilder builder(view);
  const int meshes = values.Int(1, 12);
  std::vector<HostileMesh> made;
  const int cells = 1 << values.Int(0, 3);  // A pixel's, along an axis.
  for (int i = 0; i < meshes; ++i) {
    if (!made.empty() && values.Chance(0.2)) {
      made.push_back(made[values.Index(made.size())]);
    } else {
      HostileMesh mesh{.motion = AnyMotion(values)};
      const auto vertices = uint32_t(values.Int(3, 8));
      const auto place = [&](int corner) {
        return corner + values.Int(-4 * cells, (kSide + 4) * cells) / double(cells);
      };
      // Powers of two as w change no bit of a position.
      const double w = std::ldexp(1.0, values.Int(-3, 3));
      for (uint32_t v = 0; v < vertices; ++v) {
        const bool rests = values.Chance(0.3);
        RasterPoint p;
        for (int k = 0; k < mesh.motion.Points(); ++k) {
          if (k == 0 || !rests) p = {place(rect.x) * w, place(rect.y) * w, double(i + 1) / 16 * w, w};
          mesh.points.push_back(p);
        }
      }
      mesh.triangles = AnyTriangles(values, vertices);
      made.push_back(mesh);
    }
    AddTo(builder, made.back(), {.double_sided = values.Chance(0.7)});
  }
  return {builder.Build(), rect};
}

HostileFrame Curtain(uint64_t seed) {
  HostileValues values(seed);
  const TileRect rect = AnyRect(values);
  FrameView view = PerspectiveView(kSide, kSide);
  view.width = rect.x + kSide;
  view.height = rect.y + kSide;
  if (values.Chance(0.3)) view.znear = std::exp2(values.Int(-100, 20));
  FrameSceneBuilder builder(view);
  HostileMesh mesh{.motion = AnyMotion(values)};
  const int side = values.Int(2, 7);
  const double margin = values.Chance(0.5) ? 4 : std::exp2(20 * values.Unit());
  const bool wild = values.Chance(0.7);
  const double common = values.WInFront(view.znear);
  for (int j = 0; j <= side; ++j) {
    for (int i = 0; i <= side; ++i) {
      const bool rim = i == 0 || j == 0 || i == side || j == side;
      const auto along = [&](int k) { return -margin + (kSide + 2 * margin) * k / side; };
      // Farther out, positions along a line are rounded to more than half a subpixel.
      const auto near = [](double x) { return std::clamp(x, -0x1p26, 0x1p26); };
      const bool rests = rim || values.Chance(0.2);
      RasterPoint p;
      for (int k = 0; k < mesh.motion.Points(); ++k) {
        if (k == 0 || !rests) {
          const double w = wild ? values.WInFront(view.znear) : common;
          // Small enough that the rim's coordinates are not cut.
          p = rim ? Point(rect, along(i), along(j), view.znear, std::min(w, 1e30))
                  : Point(rect, near(values.Position(kSide)), near(values.Position(kSide)), view.znear, w);
        }
        mesh.points.push_back(p);
      }
    }
  }
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const auto at = [&](int x, int y) { return uint32_t(y * (side + 1) + x); };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), values.random());
  AddTo(builder, mesh, {});
  return {builder.Build(), rect};
}

}  // namespace shutterline::engine
