#include "worker/engine/scene/tangent_space.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "common/base/work_limit.h"
#include "common/math/unit_vector.h"

namespace shutterline::engine {
namespace {

constexpr size_t kTrianglesPerCheck = 4096;

V3d Flattened(const V3d& v, const V3d& normal) {
  return v - v.dot(normal) * normal;
}

/// A unit vector at right angles to `normal`, which is unit or zero.
V3d AnyPerpendicular(const V3d& normal) {
  const V3d size(std::abs(normal.x), std::abs(normal.y), std::abs(normal.z));
  V3d axis(0);
  axis[size.x <= size.y && size.x <= size.z ? 0 : size.y <= size.z ? 1 : 2] = 1;
  return UnitOrZero(Flattened(axis, normal));
}

/// The angle between two edges at a corner, as seen along the normal.
double CornerAngle(const V3d& edge, const V3d& other, const V3d& normal) {
  const V3d a = UnitOrZero(Flattened(edge, normal)), b = UnitOrZero(Flattened(other, normal));
  return std::atan2(a.cross(b).length(), a.dot(b));
}

/// Numbers vertices so that equal ones have equal numbers: those of one position, normal and coordinate.
std::vector<uint32_t> WeldedNumbers(const MeshPrimitive& primitive, const std::vector<V2f>& coordinates) {
  // Bits are in order also where a position is not a number; adding 0 makes the two zeros one.
  using Key = std::array<uint32_t, 8>;
  const auto bits = [](float value) { return std::bit_cast<uint32_t>(value + 0.0f); };
  std::vector<Key> keys(primitive.positions.size());
  for (size_t v = 0; v < keys.size(); ++v) {
    const V3f& p = primitive.positions[v];
    const V3f& n = primitive.normals[v];
    const V2f& uv = coordinates[v];
    keys[v] = {bits(p.x), bits(p.y), bits(p.z), bits(n.x), bits(n.y), bits(n.z), bits(uv.x), bits(uv.y)};
  }
  std::vector<uint32_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return keys[a] < keys[b]; });
  std::vector<uint32_t> numbers(keys.size());
  uint32_t number = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && keys[order[i]] != keys[order[i - 1]]) ++number;
    numbers[order[i]] = number;
  }
  return numbers;
}

/// Orientations of triangles in the texture: the sign of their bitangents is 1 and -1.
enum Side : size_t { kUpright = 0, kMirrored = 1, kSides = 2 };

/// What a triangle's texture coordinates say.
struct UvDirection {
  V3d tangent{0, 0, 0};  ///< Towards growing u, of any length; zero where the coordinates span no area.
  Side side = kUpright;
};

class TangentMaker {
 public:
  TangentMaker(const MeshPrimitive& primitive, const std::vector<V2f>& coordinates)
      : primitive_(primitive), coordinates_(coordinates) {
    if (!primitive.normals.empty()) welded_ = WeldedNumbers(primitive, coordinates);
    const size_t groups = primitive.normals.empty() ? primitive.triangles.size() : primitive.positions.size();
    for (std::vector<V3d>& sums : sums_) sums.assign(groups, V3d(0));
  }

  std::vector<V4f> Make() {
    SumUp();
    std::vector<V4f> tangents;
    tangents.reserve(3 * primitive_.triangles.size());
    for (size_t t = 0; t < primitive_.triangles.size(); ++t) {
      if (t % kTrianglesPerCheck == 0) CheckWork();
      UvDirection uv = DirectionOf(t);
      if (uv.tangent == V3d(0)) uv.side = SideOfNeighbours(t);
      for (size_t k = 0; k < 3; ++k) {
        const V3d tangent = TangentAt(t, k, uv);
        tangents.emplace_back(float(tangent.x), float(tangent.y), float(tangent.z),
                              uv.side == kUpright ? 1.f : -1.f);
      }
    }
    return tangents;
  }

 private:
  V3d Position(size_t t, size_t corner) const {
    return V3d(primitive_.positions[primitive_.triangles[t][corner % 3]]);
  }

  UvDirection DirectionOf(size_t t) const {
    const std::array<uint32_t, 3>& corners = primitive_.triangles[t];
    const V2d uv(coordinates_[corners[0]]);
    const V2d uv1 = V2d(coordinates_[corners[1]]) - uv, uv2 = V2d(coordinates_[corners[2]]) - uv;
    const double area = uv1.x * uv2.y - uv1.y * uv2.x;
    UvDirection result;
    if (area == 0) return result;
    // With v downwards, a triangle that is not mirrored runs clockwise in the texture's own axes.
    result.side = area < 0 ? kUpright : kMirrored;
    const V3d edge1 = Position(t, 1) - Position(t, 0), edge2 = Position(t, 2) - Position(t, 0);
    result.tangent = UnitOrZero(uv2.y * edge1 - uv1.y * edge2) * (area < 0 ? -1.0 : 1.0);
    return result;
  }

  V3d NormalAt(size_t t, size_t k) const {
    if (!primitive_.normals.empty()) {
      const V3d normal = UnitOrZero(V3d(primitive_.normals[primitive_.triangles[t][k]]));
      if (normal != V3d(0)) return normal;
    }
    return UnitOrZero((Position(t, 1) - Position(t, 0)).cross(Position(t, 2) - Position(t, 0)));
  }

  size_t GroupOf(size_t t, size_t k) const {
    return welded_.empty() ? t : welded_[primitive_.triangles[t][k]];
  }

  void SumUp() {
    for (size_t t = 0; t < primitive_.triangles.size(); ++t) {
      if (t % kTrianglesPerCheck == 0) CheckWork();
      const UvDirection uv = DirectionOf(t);
      if (uv.tangent == V3d(0)) continue;
      for (size_t k = 0; k < 3; ++k) {
        const V3d normal = NormalAt(t, k), place = Position(t, k);
        const double angle = CornerAngle(Position(t, k + 1) - place, Position(t, k + 2) - place, normal);
        sums_[uv.side][GroupOf(t, k)] += angle * UnitOrZero(Flattened(uv.tangent, normal));
      }
    }
  }

  Side SideOfNeighbours(size_t t) const {
    for (const Side side : {kUpright, kMirrored}) {
      for (size_t k = 0; k < 3; ++k) {
        if (sums_[side][GroupOf(t, k)] != V3d(0)) return side;
      }
    }
    return kUpright;
  }

  V3d TangentAt(size_t t, size_t k, const UvDirection& uv) const {
    const V3d normal = NormalAt(t, k);
    const size_t group = GroupOf(t, k);
    for (const V3d& candidate : {sums_[uv.side][group], uv.tangent, sums_[kSides - 1 - uv.side][group]}) {
      const V3d tangent = UnitOrZero(Flattened(candidate, normal));
      if (tangent != V3d(0)) return tangent;
    }
    return AnyPerpendicular(normal);
  }

  const MeshPrimitive& primitive_;
  const std::vector<V2f>& coordinates_;
  std::vector<uint32_t> welded_;               ///< Empty without normals.
  std::array<std::vector<V3d>, kSides> sums_;  ///< Weighted directions by group.
};

}  // namespace

std::vector<V4f> MakeTangents(const MeshPrimitive& primitive, int texcoord) {
  return TangentMaker(primitive, primitive.texcoords[size_t(texcoord)]).Make();
}

}  // namespace shutterline::engine
