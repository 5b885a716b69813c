#pragma once

#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImathQuat.h>
#include <ImathVec.h>

#include <cmath>

/// Names for the spaces that the renderer works in.
///
/// - **object**: a mesh's own coordinates, metres, as stored in the glTF file.
/// - **world**: the scene's coordinates, metres, right-handed, y up.
/// - **view**: the camera's coordinates, metres; the camera looks along −z, x to the right, y up.
/// - **raster**: pixels; x to the right, y *down*, the frame's top left corner is (0, 0), the centre of
///   pixel (i, j) is (i + ½, j + ½).
/// - **tile**: raster relative to a tile's top left corner.
///
/// Matrices follow Imath: points are row vectors, `p_world = p_object * world_from_object`, and products
/// read left to right. A matrix is named `<to>_from_<from>` nevertheless.
///
/// Shutter time t runs over [0, 1] from shutter open to shutter close; animation time is in seconds.
namespace shutterline {

using V2f = Imath::V2f;
using V2d = Imath::V2d;
using V3f = Imath::V3f;
using V3d = Imath::V3d;
using V4f = Imath::V4f;
using V4d = Imath::V4d;
using M44d = Imath::M44d;
using Quatd = Imath::Quatd;
using Box3f = Imath::Box3f;
using Box3d = Imath::Box3d;

/// A point in homogeneous raster space: its raster position is (x/w, y/w) in pixels and its depth is
/// d = z/w. Depth is *reversed*: 1 at the near plane, falling towards 0 at infinity (perspective) or at
/// the far plane (orthographic); the larger of two depths is the nearer. A point is in front of the near
/// plane where z <= w. For perspective cameras w is the distance along the view direction in metres.
/// Depth is an affine function of raster position on a plane, hence linear along a line sample.
struct RasterPoint {
  double x = 0, y = 0, z = 0, w = 0;

  friend RasterPoint operator+(const RasterPoint& a, const RasterPoint& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w};
  }
  friend RasterPoint operator-(const RasterPoint& a, const RasterPoint& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w};
  }
  friend RasterPoint operator*(double s, const RasterPoint& p) {
    return {s * p.x, s * p.y, s * p.z, s * p.w};
  }
  friend bool operator==(const RasterPoint&, const RasterPoint&) = default;

  bool IsFinite() const {
    return std::isfinite(x) && std::isfinite(y) && std::isfinite(z) && std::isfinite(w);
  }
};

}  // namespace shutterline
