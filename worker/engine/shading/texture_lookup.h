#pragma once

#include <array>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/barycentric.h"
#include "worker/engine/shading/texture_walk.h"

namespace shutterline::engine {

/// Looks at the textures of one point of a triangle. Those that share coordinates, transform, size and
/// wrapping, as a material's mostly do, share one walk over the pixel's footprint if they are asked for in a
/// row. What it is made of must outlive it.
class TextureLookup {
 public:
  /// `corners` are the triangle's vertices in the mesh, `weights` their barycentric weights.
  TextureLookup(const FrameScene& frame, const MeshPrimitive& source, const std::array<size_t, 3>& corners,
                const std::array<double, 3>& weights, const Footprint& footprint)
      : frame_(frame), source_(source), corners_(corners), weights_(weights), footprint_(footprint) {}

  /// Linear colour and alpha; white where the texture is not used.
  V4d Color(const TextureRef& reference, TextureEncoding encoding);

  /// Finds out where to look and has memory send what is there: textures are larger than caches, and there is
  /// other work to be done until it comes.
  void Prefetch(const TextureRef& reference, TextureEncoding encoding);

 private:
  /// Makes walk_ that of the texture; its pyramid, null where it is not used.
  const MipPyramid* Walk(const TextureRef& reference, TextureEncoding encoding);
  /// Sets uv_ and its derivatives.
  void Place(const TextureRef& reference);

  const FrameScene& frame_;
  const MeshPrimitive& source_;
  const std::array<size_t, 3>& corners_;
  const std::array<double, 3>& weights_;
  const Footprint& footprint_;
  int texcoord_ = -1;  ///< Of what uv_ is; -1: nothing yet.
  TextureTransform transform_;
  V2d uv_{0, 0}, duv_dx_{0, 0}, duv_dy_{0, 0};
  WalkedImage walked_;  ///< Of what walk_ is; of width 0: nothing yet.
  TextureWalk walk_;
};

/// Whether the frame has the texture, in this encoding, and the mesh the coordinates for it.
bool IsUsed(const FrameScene& frame, const MeshPrimitive& source, const TextureRef& reference,
            TextureEncoding encoding);

}  // namespace shutterline::engine
