#pragma once

#include <array>

namespace shutterline::engine {

/// What a GGX surface reflects of light that comes from everywhere alike, towards a viewer: with Schlick's
/// reflectance f0 · scale + f90 · bias [karis2013]. With f0 = f90 = 1 less than 1 is left, scale + bias, as
/// one reflection is counted; what is lost is what later ones between facets would bring back [kulla2017].
struct DirectionalAlbedo {
  double scale = 1, bias = 0;
};

/// `n_dot_v` and `roughness` (the square root of α) in [0, 1]. From a table, made by quadrature when first
/// asked; within 0.005 of the integral. Thread-safe.
DirectionalAlbedo GgxDirectionalAlbedo(double n_dot_v, double roughness);

/// That table: by roughness, then by N·V, both equally spaced from 0 to 1. Linear in between.
struct DirectionalAlbedoTable {
  static constexpr int kSide = 32;

  /// Thread-safe.
  static const DirectionalAlbedoTable& Get();

  std::array<std::array<DirectionalAlbedo, kSide>, kSide> rows;
};

/// The integral itself by `samples` points.
DirectionalAlbedo IntegrateDirectionalAlbedo(double n_dot_v, double roughness, int samples);

}  // namespace shutterline::engine
