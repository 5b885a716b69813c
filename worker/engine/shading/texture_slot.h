#pragma once

#include <cstddef>
#include <cstdint>

namespace shutterline::engine {

/// The textures of a material.
enum class TextureSlot : uint8_t {
  kBaseColor,
  kMetallicRoughness,
  kNormal,
  kOcclusion,
  kEmissive,
  kSpecular,
  kSpecularColor,
};
inline constexpr size_t kTextureSlots = 7;

}  // namespace shutterline::engine
