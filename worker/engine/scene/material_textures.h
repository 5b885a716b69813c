#pragma once

#include <vector>

#include "worker/engine/scene/mip_pyramid.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// One of a material's textures, and how its image is encoded.
struct MaterialTexture {
  const char* role;             ///< For people: "normal".
  const TextureRef* reference;  ///< In the material.
  TextureEncoding encoding;
};

/// The textures that shading reads: those that the material has; of unlit ones the base colour's alone.
std::vector<MaterialTexture> TexturesOf(const Material& material);

/// Whether a mesh primitive of this material shows a normal texture: it is lit, has one, and the primitive
/// has the texture coordinates.
bool ShowsNormalTexture(const Material& material, const MeshPrimitive& primitive);

}  // namespace shutterline::engine
