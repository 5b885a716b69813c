#pragma once

namespace shutterline::engine {

/// Barycentric coordinates of a point in a triangle's own (object-space) parametrisation: the point is
/// (1 - b1 - b2) v0 + b1 v1 + b2 v2, with b1, b2 >= 0 and b1 + b2 <= 1.
struct Barycentric {
  double b1 = 0, b2 = 0;
};

/// How large a raster pixel is on the triangle at the shading point: derivatives of the barycentric
/// coordinates with respect to raster x and y, per pixel. Selects mip levels. Zeros mean level 0.
struct Footprint {
  double db1_dx = 0, db1_dy = 0, db2_dx = 0, db2_dy = 0;
  /// A rough look will do: textures are blurred in all directions alike.
  bool rough = false;
};

}  // namespace shutterline::engine
