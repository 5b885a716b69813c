#include "worker/engine/occlusion/receiver.h"

#include <algorithm>
#include <cmath>

#include "common/math/unit_vector.h"

namespace shutterline::engine {
namespace {

/// The axes of a triangle: along its first edge, across it, along its face. Nothing without area.
std::optional<std::array<V3d, 3>> AxesOf(const std::array<V3d, 3>& corners) {
  const V3d along = UnitOrZero(corners[1] - corners[0]);
  const V3d face = UnitOrZero(along.cross(UnitOrZero(corners[2] - corners[0])));
  if (face == V3d(0)) return std::nullopt;
  return std::array<V3d, 3>{along, face.cross(along), face};
}

void Measure(const std::array<V3d, 3>& corners, ReceiverFrame& frame) {
  frame.size = 0;
  for (const V3d& p : corners)
    frame.size = std::max(frame.size, std::abs(p.x) + std::abs(p.y) + std::abs(p.z));
  const double longest = std::max({(corners[1] - corners[0]).length(), (corners[2] - corners[1]).length(),
                                   (corners[0] - corners[2]).length()});
  frame.least_height = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length() / longest;
}

/// A unit vector at right angles to the pole, as the world's axes have it: smooth but for one direction.
V3d FirstAxis(const FrameView& view, const V3d& pole) {
  const V3d n = view.WorldFromView(pole);
  // The axis least along the pole would jump; this turns the world's x axis with the pole, away from -z.
  const double sign = n.z < 0 ? -1 : 1;
  const double a = -1 / (sign + n.z);
  const V3d in_world(1 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x);
  const V3d in_view =
      in_world.x * view.world_axes[0] + in_world.y * view.world_axes[1] + in_world.z * view.world_axes[2];
  const V3d x = UnitOrZero(in_view - in_view.dot(pole) * pole);
  if (x != V3d(0)) return x;
  const V3d other = std::abs(pole.x) < 0.5 ? V3d(1, 0, 0) : V3d(0, 1, 0);
  return UnitOrZero(other - other.dot(pole) * pole);
}

}  // namespace

std::array<V3d, 3> Receiver::CornersAt(double t) const {
  std::array<V3d, 3> corners;
  for (size_t k = 0; k < 3; ++k) {
    corners[k] =
        frame_->view.ViewFromRaster(frame_->VertexAt(*primitive_, triangle_->vertices[k], t)) / scale_;
  }
  return corners;
}

std::optional<Receiver> Receiver::Create(const FrameScene& frame, uint32_t triangle, double b1, double b2,
                                         double scale) {
  Receiver r;
  r.frame_ = &frame;
  r.triangle_ = &frame.triangles[triangle];
  r.primitive_ = &frame.primitives[r.triangle_->primitive];
  r.b1_ = b1;
  r.b2_ = b2;
  r.scale_ = scale;
  const std::array<V3d, 3> corners = r.CornersAt(0.5);
  const auto axes = AxesOf(corners);
  if (!axes) return std::nullopt;
  ReceiverFrame& middle = r.middle_;
  const std::array<double, 3> weights{1 - b1 - b2, b1, b2};
  V3d normal(0);
  for (size_t k = 0; k < 3; ++k) {
    middle.position += weights[k] * corners[k];
    if (r.primitive_->has_normals) {
      const size_t local = r.triangle_->vertices[k] - r.primitive_->first_vertex;
      normal += weights[k] * V3d(frame.normals[r.primitive_->first_normal + local]);
    }
  }

  // Turn the face to the camera and the normal to the face, as shading does.
  const V3d to_camera = frame.view.perspective ? -middle.position : V3d(0, 0, 1);
  r.side_ = (*axes)[2].dot(to_camera) < 0 ? -1 : 1;
  middle.face = r.side_ * (*axes)[2];
  middle.pole = UnitOrZero(normal);
  if (middle.pole == V3d(0)) middle.pole = middle.face;
  if (middle.pole.dot(middle.face) < 0) middle.pole = -middle.pole;
  middle.x = FirstAxis(frame.view, middle.pole);
  middle.y = middle.pole.cross(middle.x);
  Measure(corners, middle);
  for (int k = 0; k < 3; ++k) {
    r.pole_[k] = middle.pole.dot((*axes)[size_t(k)]);
    r.x_[k] = middle.x.dot((*axes)[size_t(k)]);
  }

  const RasterPoint at = frame.view.RasterFromView(scale * middle.position);
  r.shifts_ = ShiftsOfPixel(at.x / at.w, at.y / at.w);
  return r;
}

ReceiverFrame Receiver::At(double t) const {
  if (IsStill() || t == 0.5) return middle_;
  ReceiverFrame now = middle_;
  const std::array<V3d, 3> corners = CornersAt(t);
  now.position = (1 - b1_ - b2_) * corners[0] + b1_ * corners[1] + b2_ * corners[2];
  const auto axes = AxesOf(corners);
  if (!axes) return now;
  now.face = side_ * (*axes)[2];
  // Where the normal is the face's, it stays so to the last bit.
  if (middle_.pole == middle_.face) {
    now.pole = now.face;
  } else {
    now.pole = UnitOrZero(pole_.x * (*axes)[0] + pole_.y * (*axes)[1] + pole_.z * (*axes)[2]);
  }
  const V3d x = x_.x * (*axes)[0] + x_.y * (*axes)[1] + x_.z * (*axes)[2];
  now.x = UnitOrZero(x - x.dot(now.pole) * now.pole);
  now.y = now.pole.cross(now.x);
  Measure(corners, now);
  return now;
}

}  // namespace shutterline::engine
