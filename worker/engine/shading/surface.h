#pragma once

#include <array>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/footprint.h"
#include "worker/engine/shading/prepared_material.h"
#include "worker/engine/shading/texture_lookup.h"

namespace shutterline::engine {

/// What a material is at a point of a triangle, in view space at mid-shutter.
struct Surface {
  V3d position{0, 0, 0};
  V3d to_camera{0, 0, 1};  ///< Unit.
  V3d face{0, 0, 1};       ///< Unit normal of the triangle, on the camera's side.
  V3d normal{0, 0, 1};     ///< Unit, with interpolation and normal texture; on the camera's side of the face.
  V3d base_color{1, 1, 1};
  double metallic = 0, roughness = 1;
  V3d f0{0.04, 0.04, 0.04};  ///< Reflectance head-on, of metal and dielectric together.
  double f90 = 1;
  double occlusion = 1;  ///< Of light from everywhere.
  V3d emission{0, 0, 0};
};

/// A triangle of a frame with what the points of its surface have in common. Refers to the frame and to the
/// primitive's material.
struct SurfaceTriangle {
  SurfaceTriangle() = default;
  SurfaceTriangle(const FrameScene& frame, const PreparedMaterial& material, uint32_t triangle);

  /// Of its corners' in the frame's tangents, where its primitive has any.
  size_t FirstTangent() const {
    return primitive->first_tangent + 3 * size_t(number - primitive->first_triangle);
  }

  uint32_t number = 0;  ///< In the frame.
  const FramePrimitive* primitive = nullptr;
  const PreparedMaterial* material = nullptr;
  TexturedTriangle textured;
  std::array<RasterPoint, 3> raster{};  ///< At mid-shutter.
  std::array<V3d, 3> corners{};         ///< In view space.
  V3d face{0, 0, 0};                    ///< Unit, on the front; zero where the triangle has no normal.
};

/// Base colour and alpha without the texture: factor × vertex colour. `corners`: see TexturedTriangle.
V4d TintAt(const FramePrimitive& primitive, const std::array<size_t, 3>& corners, const Barycentric& at);

/// Base colour: factor × vertex colour × texture, with the alpha that they multiply to. All that an unlit
/// material shows. `triangle` is one of the primitive's.
V4d BaseColorAt(const FramePrimitive& primitive, const PreparedMaterial& material,
                const FrameTriangle& triangle, const Barycentric& at, const Footprint& footprint);

/// Everything. Unlit materials have a normal, too, that of the face.
Surface SurfaceAt(const FrameScene& frame, const SurfaceTriangle& triangle, const Barycentric& at,
                  const Footprint& footprint);

/// Whether any of the material's textures is.
bool IsTextured(const FrameScene& frame, const FramePrimitive& primitive);

}  // namespace shutterline::engine
