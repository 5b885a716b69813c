#include "tests/scenes/shapes.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace shutterline::scenes {
namespace {

V3f TriangleCross(const V3f& a, const V3f& b, const V3f& c) {
  return (b - a).cross(c - a);
}

}  // namespace

V3f Srgb(uint32_t rgb) {
  const auto linear = [](uint32_t byte) {
    const double s = double(byte & 255) / 255;
    return float(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
  };
  return V3f(linear(rgb >> 16), linear(rgb >> 8), linear(rgb));
}

void AddSurface(Primitive& primitive, int columns, int rows,
                const std::function<V3f(double, double)>& surface, bool smooth) {
  std::vector<V3f> grid;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) grid.push_back(surface(double(i) / columns, double(j) / rows));
  }
  const auto at = [&](int i, int j) { return size_t(j) * size_t(columns + 1) + size_t(i); };
  std::vector<std::array<size_t, 3>> triangles;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  if (!smooth) {
    for (const auto& [a, b, c] : triangles) AddPolygon(primitive, {grid[a], grid[b], grid[c]});
    return;
  }
  const uint32_t first = uint32_t(primitive.positions.size());
  std::vector<V3f> normals(grid.size(), V3f(0));
  for (const auto& triangle : triangles) {
    const V3f cross = TriangleCross(grid[triangle[0]], grid[triangle[1]], grid[triangle[2]]);
    for (const size_t corner : triangle) normals[corner] += cross;
    primitive.triangles.push_back(
        {first + uint32_t(triangle[0]), first + uint32_t(triangle[1]), first + uint32_t(triangle[2])});
  }
  for (V3f& normal : normals) normal = normal.length() > 0 ? normal.normalized() : V3f(0, 0, 1);
  primitive.positions.insert(primitive.positions.end(), grid.begin(), grid.end());
  primitive.normals.insert(primitive.normals.end(), normals.begin(), normals.end());
}

void AddPolygon(Primitive& primitive, const std::vector<V3f>& corners) {
  SL_CHECK(corners.size() >= 3);
  const uint32_t first = uint32_t(primitive.positions.size());
  const V3f cross = TriangleCross(corners[0], corners[1], corners[2]);
  const V3f normal = cross.length() > 0 ? cross.normalized() : V3f(0, 0, 1);
  for (const V3f& corner : corners) {
    primitive.positions.push_back(corner);
    primitive.normals.push_back(normal);
  }
  for (uint32_t i = 2; i < corners.size(); ++i)
    primitive.triangles.push_back({first, first + i - 1, first + i});
}

void AddBox(Primitive& primitive, const V3f& min, const V3f& max) {
  // Bit k of a corner's number chooses max on axis k.
  const auto corner = [&](int bits) {
    return V3f(bits & 1 ? max.x : min.x, bits & 2 ? max.y : min.y, bits & 4 ? max.z : min.z);
  };
  constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& face : kFaces) {
    AddPolygon(primitive, {corner(face[0]), corner(face[1]), corner(face[2]), corner(face[3])});
  }
}

void FrameOf(const V3f& direction, V3f& a, V3f& b) {
  const V3f other = std::abs(direction.y) < 0.9f ? V3f(0, 1, 0) : V3f(1, 0, 0);
  a = other.cross(direction).normalized();
  b = direction.cross(a);
}

void AddTube(Primitive& primitive, const V3f& a, const V3f& b, float radius_a, float radius_b, int sides) {
  V3f x, y;
  FrameOf((b - a).normalized(), x, y);
  AddSurface(primitive, sides, 1, [&](double u, double v) {
    const double angle = 2 * M_PI * u;
    const V3f out = x * float(std::cos(angle)) + y * float(std::sin(angle));
    return v == 0 ? a + out * radius_a : b + out * radius_b;
  });
}

void AddSphere(Primitive& primitive, const V3f& centre, float radius, int columns, int rows) {
  AddSurface(primitive, columns, rows, [&](double u, double v) {
    const double longitude = 2 * M_PI * u, latitude = M_PI * (v - 0.5);
    const V3f out(float(std::cos(latitude) * std::sin(longitude)), float(std::sin(latitude)),
                  float(std::cos(latitude) * std::cos(longitude)));
    return centre + out * radius;
  });
}

void AddTorus(Primitive& primitive, const V3f& centre, float ring_radius, float tube_radius, int columns,
              int rows) {
  AddSurface(primitive, columns, rows, [&](double u, double v) {
    const double ring = 2 * M_PI * u, tube = 2 * M_PI * v;
    const float radius = ring_radius + tube_radius * float(std::cos(tube));
    return centre + V3f(radius * float(std::cos(ring)), radius * float(std::sin(ring)),
                        tube_radius * float(std::sin(tube)));
  });
}

void AddRegularSolid(Primitive& primitive, int faces, float radius) {
  SL_CHECK(faces == 4 || faces == 6 || faces == 8 || faces == 20);
  if (faces == 6) {
    const V3f half(radius / std::sqrt(3.0f));
    AddBox(primitive, -half, half);
    return;
  }
  std::vector<V3f> corners;
  if (faces == 4) corners = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  if (faces == 8) corners = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  if (faces == 20) {
    const float g = (1 + std::sqrt(5.0f)) / 2;
    for (const float s : {-1.0f, 1.0f}) {
      for (const float h : {-g, g}) {
        corners.insert(corners.end(), {V3f(0, s, h), V3f(s, h, 0), V3f(h, 0, s)});
      }
    }
  }
  for (V3f& corner : corners) corner = corner.normalized() * radius;
  // A face is every triple with all other corners behind it; its order follows from the outward side.
  const size_t n = corners.size();
  int found = 0;
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = i + 1; j < n; ++j) {
      for (size_t k = j + 1; k < n; ++k) {
        V3f normal = TriangleCross(corners[i], corners[j], corners[k]);
        const bool outward = normal.dot(corners[i]) > 0;
        if (!outward) normal = -normal;
        const bool is_face = std::all_of(corners.begin(), corners.end(), [&](const V3f& corner) {
          return normal.normalized().dot(corner - corners[i]) < 1e-4f * radius;
        });
        if (!is_face || normal.dot(corners[i]) <= 1e-6f * radius * radius * radius) continue;
        AddPolygon(primitive, {corners[i], corners[outward ? j : k], corners[outward ? k : j]});
        ++found;
      }
    }
  }
  SL_CHECK(found == faces);
}

}  // namespace shutterline::scenes
