#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "tests/support/frame_scene_builder.h"
#include "worker/engine/occlusion/ambient_occlusion.h"

/// Frames made of few shapes about a point that asks for its occlusion.
namespace shutterline::engine {

using Mesh3 = std::pair<std::vector<V3d>, std::vector<std::array<uint32_t, 3>>>;

/// From the local frame of the point, whose pole is z, to view space. By default the point lies before the
/// camera and looks at it.
struct Placement {
  std::function<V3d(const V3d&)> view = [](const V3d& p) { return p + V3d(0, 0, -5); };
};

/// The quadrilateral with these corners, in order.
inline Mesh3 Quad(const V3d& a, const V3d& b, const V3d& c, const V3d& d) {
  return {{a, b, c, d}, {{0, 1, 2}, {0, 2, 3}}};
}

inline Mesh3 Disc(double radius, double height, uint32_t sides) {
  Mesh3 mesh;
  mesh.first.push_back({0, 0, height});
  for (uint32_t i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    mesh.first.push_back({radius * std::cos(angle), radius * std::sin(angle), height});
    mesh.second.push_back({0, 1 + i, 1 + (i + 1) % sides});
  }
  return mesh;
}

inline Mesh3 Sphere(const V3d& centre, double radius, uint32_t rows) {
  const uint32_t columns = 2 * rows;
  Mesh3 mesh;
  for (uint32_t r = 0; r <= rows; ++r) {
    for (uint32_t c = 0; c < columns; ++c) {
      const double polar = std::numbers::pi * r / rows, azimuth = 2 * std::numbers::pi * c / columns;
      mesh.first.push_back(centre + radius * V3d(std::sin(polar) * std::cos(azimuth),
                                                 std::sin(polar) * std::sin(azimuth), std::cos(polar)));
      if (r == rows) continue;
      const uint32_t a = r * columns + c, b = r * columns + (c + 1) % columns;
      mesh.second.push_back({a, a + columns, b + columns});
      mesh.second.push_back({a, b + columns, b});
    }
  }
  return mesh;
}

inline Mesh3 Moved(Mesh3 mesh, const V3d& by) {
  for (V3d& p : mesh.first) p += by;
  return mesh;
}

class OcclusionScene {
 public:
  explicit OcclusionScene(Placement placement = {})
      : placement_(std::move(placement)), builder_(PerspectiveView(64, 64)) {
    AddReceiver();
  }

  /// A triangle about the origin that faces the pole; its middle asks. It must come first.
  void AddReceiver() { Add({{{-0.01, -0.01, 0}, {0.02, -0.01, 0}, {-0.01, 0.02, 0}}, {{0, 1, 2}}}); }
  void Add(const Mesh3& mesh) { builder_.AddViewMesh(Placed(mesh.first), {}, mesh.second); }
  void AddMoving(const Mesh3& open, const Mesh3& close) {
    builder_.AddViewMesh(Placed(open.first), Placed(close.first), open.second);
  }

  std::shared_ptr<const FrameScene> Build() const { return builder_.Build(); }
  FrameSceneBuilder& builder() { return builder_; }

  double Open(const OcclusionSettings& settings, const LineShifts& shifts = {}) const {
    const auto occlusion = AmbientOcclusion::Create(Build(), settings, 1);
    return occlusion.ok() ? occlusion->At(0, 1.0 / 3, 1.0 / 3, shifts) : -1;
  }

 private:
  std::vector<V3d> Placed(const std::vector<V3d>& points) const {
    std::vector<V3d> placed;
    for (const V3d& p : points) placed.push_back(placement_.view(p));
    return placed;
  }

  Placement placement_;
  FrameSceneBuilder builder_;
};

}  // namespace shutterline::engine
