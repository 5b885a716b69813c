#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/math/spaces.h"
#include "worker/engine/occlusion/hemisphere_lines.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// A shading point and its axes at an instant, in view space divided by a scale.
struct ReceiverFrame {
  V3d position{0, 0, 0};
  V3d face{0, 0, 1};  ///< Unit normal of the triangle.
  V3d pole{0, 0, 1};  ///< Unit shading normal; `x`, `y` and `pole` are a right-handed frame.
  V3d x{1, 0, 0}, y{0, 1, 0};
  /// How thin the triangle is: its least height. What its plane is known to, far away, goes by it.
  double least_height = 0;
  double size = 0;  ///< Largest sum of the magnitudes of a corner's coordinates.
};

/// A point of a moving triangle that asks what it sees of its hemisphere. The hemisphere is that of the
/// interpolated normal, where the mesh has normals, so that shading is smooth where the surface is meant to
/// be; on the side that the camera is on at mid-shutter. The axes move with the triangle. At mid-shutter the
/// frame's x axis lies as the world has it, whatever the triangle, so neighbours have the same lines.
/// Immutable.
class Receiver {
 public:
  /// `scale`: metres a unit. Nothing where the triangle has no area at mid-shutter.
  static std::optional<Receiver> Create(const FrameScene& frame, uint32_t triangle, double b1, double b2,
                                        double scale);

  /// At shutter time t. Where the triangle has no area then, its axes are those of mid-shutter.
  ReceiverFrame At(double t) const;
  /// Axes and place do not depend on t.
  bool IsStill() const { return primitive_->degree == 0; }
  /// The shifts of the pixel in which the point is at mid-shutter.
  const LineShifts& shifts() const { return shifts_; }

 private:
  /// A vector by its parts along the triangle's first edge, across it and along its face.
  using Parts = V3d;

  Receiver() = default;

  std::array<V3d, 3> CornersAt(double t) const;

  const FrameScene* frame_ = nullptr;
  const FramePrimitive* primitive_ = nullptr;
  const FrameTriangle* triangle_ = nullptr;
  double b1_ = 0, b2_ = 0, scale_ = 1;
  double side_ = 1;  ///< -1 where the camera sees the back.
  Parts pole_{0, 0, 1}, x_{1, 0, 0};
  ReceiverFrame middle_;
  LineShifts shifts_;
};

}  // namespace shutterline::engine
