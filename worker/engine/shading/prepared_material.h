#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/texture_slot.h"
#include "worker/engine/shading/texture_transform.h"
#include "worker/engine/shading/texture_walk.h"

namespace shutterline::engine {

/// Texture coordinates over a triangle: origin + b1 · along1 + b2 · along2.
struct TriangleCoordinates {
  V2d origin{0, 0}, along1{0, 0}, along2{0, 0};
};

/// A texture of a material on a primitive.
struct PreparedTexture {
  const MipPyramid* pyramid = nullptr;  ///< Null: not used.
  WalkedImage image;
  int coordinates = 0;  ///< Which of the material's.
  int walk = 0;         ///< Textures with the same number are looked at in the same places of equal pyramids.
};

/// A material on a primitive, with what is the same at all its points: found once a frame. Refers to the
/// frame.
class PreparedMaterial {
 public:
  PreparedMaterial() = default;
  PreparedMaterial(const FrameScene& frame, const FramePrimitive& primitive);

  /// A texture of a mesh. Not thread-safe.
  PreparedTexture Prepare(const FrameScene& frame, const MeshPrimitive& source, const TextureRef& reference,
                          TextureEncoding encoding);

  /// Texture coordinates number `n` over the triangle with these vertices of the mesh.
  TriangleCoordinates CoordinatesOn(int n, const std::array<size_t, 3>& corners) const;
  bool HasCoordinates() const { return !coordinates_.empty(); }

  const PreparedTexture& Of(TextureSlot slot) const { return textures_[size_t(slot)]; }
  double head_on = 0.04;  ///< The square of (n - 1) / (n + 1), n being the index of refraction.

 private:
  struct Coordinates {
    const std::vector<V2f>* of_vertices;
    TextureTransform transform;
    std::optional<TurnAndScale> turned;  ///< Nothing: the transform changes nothing.
  };
  int CoordinatesOf(const std::vector<V2f>& of_vertices, const TextureTransform& transform);
  int WalkOf(int coordinates, const WalkedImage& image);

  std::array<PreparedTexture, kTextureSlots> textures_;
  std::vector<Coordinates> coordinates_;
  std::vector<std::pair<int, WalkedImage>> walks_;
};

}  // namespace shutterline::engine
