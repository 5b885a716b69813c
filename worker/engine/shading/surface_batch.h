#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "worker/engine/shading/texture_slot.h"

namespace shutterline::engine {

/// Points on triangles of one primitive, number by number in arrays, for vectors to shade. What is in view
/// space is at mid-shutter. Small enough to stay in the second cache.
struct SurfaceBatch {
  static constexpr size_t kMost = 32;
  template <typename T>
  using Array = std::array<T, kMost>;
  /// Arrays of a vector's components, or of those of three corners one after another.
  template <typename T, size_t kCount>
  using Arrays = std::array<Array<T>, kCount>;

  size_t count = 0;
  alignas(64) Array<double> b1{}, b2{};  ///< Barycentric coordinates.

  // Of the triangles.
  alignas(64) Arrays<double, 9> raster{};       ///< x, y and w of the corners.
  alignas(64) Arrays<double, 9> corners{};      ///< View space.
  alignas(64) Arrays<double, 3> face{};         ///< See SurfaceTriangle.
  alignas(64) Arrays<float, 9> normals{};       ///< Of the vertices, if there are any.
  alignas(64) Arrays<float, 12> tangents{};     ///< Likewise.
  alignas(64) Arrays<double, 6> coordinates{};  ///< TriangleCoordinates of the walk that is planned.
  alignas(64) Arrays<double, 3> tint{};         ///< Base colour without its texture.

  alignas(64) Arrays<double, 4> footprint{};  ///< Footprint's four derivatives, by MeasureFootprints.

  // A WalkPlan's members, by PlanWalks.
  alignas(64) Array<double> u{}, v{}, step_u{}, step_v{};
  alignas(64) Array<int32_t> probes{}, level{};
  alignas(64) Array<float> between{};

  alignas(64) std::array<Arrays<float, 4>, kTextureSlots> texels{};  ///< By TextureSlot, where one is used.

  // By LightSurfaces.
  alignas(64) Arrays<float, 3> radiance{};
  /// Whether directions vanished or numbers were so large or small that vectors did not look closely: such
  /// points have to be shaded one by one.
  alignas(64) Array<bool> is_odd{};
};

}  // namespace shutterline::engine
