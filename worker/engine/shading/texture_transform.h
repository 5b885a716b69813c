#pragma once

#include <cmath>

#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// KHR_texture_transform without its offset, as directions are mapped: scaled, then turned counter-clockwise
/// as one sees it with v downwards. (The matrix in the extension's text turns the other way; its words, its
/// test asset and its viewers turn this way.)
inline V2d TurnedAndScaled(const TextureTransform& transform, const V2d& uv) {
  const double c = std::cos(transform.rotation), s = std::sin(transform.rotation);
  const V2d scaled(transform.scale.x * uv.x, transform.scale.y * uv.y);
  return {c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x};
}

}  // namespace shutterline::engine
