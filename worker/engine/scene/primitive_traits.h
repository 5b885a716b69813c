#pragma once

namespace shutterline::engine {

/// What of a primitive visibility must know, made once a frame (TraitsOf, shade.h).
struct PrimitiveTraits {
  bool cull_back = false;       ///< Not drawn where it is seen from behind.
  bool needs_position = false;  ///< Shading varies over a triangle: pairs must say where on it they lie.
  bool textured = false;
  bool glossy = false;  ///< Shading changes quickly with direction.
  /// It lets light through somewhere: what lies behind it is seen as far as its alpha leaves it.
  bool layer = false;
  /// Of a layer: its alpha where that is the same all over, else -1.
  float layer_alpha = 1;
  /// Above 0: what has less alpha is not there, and the rest is opaque.
  float alpha_cutoff = 0;
};

}  // namespace shutterline::engine
