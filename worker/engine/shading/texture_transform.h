#pragma once

#include <cmath>

#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// KHR_texture_transform without its offset, as directions are mapped: scaled, then turned counter-clockwise
/// as one sees it with v downwards. (The matrix in the extension's text turns the other way; its words, its
/// test asset and its viewers turn this way.)
class TurnAndScale {
 public:
  explicit TurnAndScale(const TextureTransform& transform)
      : cosine_(std::cos(transform.rotation)), sine_(std::sin(transform.rotation)), scale_(transform.scale) {}

  V2d operator()(const V2d& uv) const {
    const V2d scaled(scale_.x * uv.x, scale_.y * uv.y);
    return {cosine_ * scaled.x + sine_ * scaled.y, cosine_ * scaled.y - sine_ * scaled.x};
  }

 private:
  double cosine_, sine_;
  V2d scale_;
};

}  // namespace shutterline::engine
