#pragma once

#include <array>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/barycentric.h"
#include "worker/engine/shading/prepared_material.h"
#include "worker/engine/shading/texture_walk.h"

namespace shutterline::engine {

/// A triangle as textures know it.
struct TexturedTriangle {
  std::array<size_t, 3> corners{};  ///< Its vertices in the mesh.
  TriangleCoordinates first;        ///< Coordinates number 0 of the material, if it has any.

  TexturedTriangle() = default;
  TexturedTriangle(const PreparedMaterial& material, const std::array<size_t, 3>& vertices)
      : corners(vertices) {
    if (material.HasCoordinates()) first = material.CoordinatesOn(0, corners);
  }
};

/// Looks at the textures of one point of a triangle. Those that share coordinates, transform, size and
/// wrapping, as a material's mostly do, share one walk over the pixel's footprint if they are asked for in a
/// row. What it is made of must outlive it.
class TextureLookup {
 public:
  TextureLookup(const PreparedMaterial& material, const TexturedTriangle& triangle, const Barycentric& at,
                const Footprint& footprint)
      : material_(material), triangle_(triangle), at_(at), footprint_(footprint) {}

  /// Linear colour and alpha; white where the texture is not used.
  V4d Color(const PreparedTexture& texture);

  /// Finds out where to look and has memory send what is there: textures are larger than caches, and there is
  /// other work to be done until it comes.
  void Prefetch(const PreparedTexture& texture);

 private:
  /// Makes walk_ that of a texture that is used.
  void Walk(const PreparedTexture& texture);
  /// Sets uv_ and its derivatives.
  void Place(int coordinates);

  const PreparedMaterial& material_;
  const TexturedTriangle& triangle_;
  const Barycentric& at_;
  const Footprint& footprint_;
  int placed_ = -1;  ///< Of what coordinates uv_ is; -1: nothing yet.
  V2d uv_{0, 0}, duv_dx_{0, 0}, duv_dy_{0, 0};
  int walked_ = -1;  ///< PreparedTexture::walk of walk_; -1: nothing yet.
  TextureWalk walk_;
};

/// Null where the frame does not have the texture, in this encoding, or the mesh the coordinates for it.
const MipPyramid* PyramidOf(const FrameScene& frame, const MeshPrimitive& source, const TextureRef& reference,
                            TextureEncoding encoding);

/// Whether there is one.
bool IsUsed(const FrameScene& frame, const MeshPrimitive& source, const TextureRef& reference,
            TextureEncoding encoding);

}  // namespace shutterline::engine
