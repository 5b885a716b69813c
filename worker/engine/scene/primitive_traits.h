#pragma once

namespace shutterline::engine {

/// What of a primitive visibility must know, made once a frame (TraitsOf, shade.h).
struct PrimitiveTraits {
  bool cull_back = false;       ///< Not drawn where it is seen from behind.
  bool needs_position = false;  ///< Shading varies over a triangle: pairs must say where on it they lie.
  bool textured = false;
};

}  // namespace shutterline::engine
