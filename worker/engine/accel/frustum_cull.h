#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/job/tile.h"
#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// Bounds in view space divided by a scale, rounded outwards.
struct ViewBounds {
  std::array<float, 3> lower, upper;
};

/// The frustum of a rectangle of pixels between the near and the far plane: six half-spaces that are
/// linear in view space as well as in homogeneous raster space. A point that moves on a Bezier curve stays
/// in the hull of its control points, so what has all of them outside one half-space is outside over the
/// whole shutter; that holds behind the eye too, where dividing by w would not.
///
/// Tests are conservative: a value counts as outside only where it is so by more than its rounding error.
class TileFrustum {
 public:
  enum class Side { kOutside, kCrossing, kInside };

  /// `scale`: metres a unit of the bounds that ClassifyBox is given.
  TileFrustum(const FrameView& view, const TileRect& rect, double scale);

  /// kOutside: nothing in the box is ever visible. kInside: all of it lies in all half-spaces, but for
  /// rounding.
  Side ClassifyBox(const ViewBounds& box) const;

  /// False if all points lie strictly outside one of the half-spaces.
  bool MayContain(std::span<const RasterPoint> points) const;

 private:
  /// A half-space n·p + offset >= 0.
  struct Plane {
    V3d normal;
    double offset = 0;
  };

  std::array<Plane, 6> planes_;           ///< Scaled view space.
  double x0_, x1_, y0_, y1_, far_depth_;  ///< Raster space.
};

}  // namespace shutterline::engine
