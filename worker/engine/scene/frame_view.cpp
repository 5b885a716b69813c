#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/status_macros.h"
#include "worker/engine/scene/camera_select.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {
namespace {

absl::Status Require(bool condition, absl::string_view field, double value, absl::string_view rule) {
  if (condition) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(field, " is ", value, ", but must be ", rule));
}

}  // namespace

double FrameView::FarDepth() const {
  return perspective && zfar > 0 ? znear / zfar : 0;
}

absl::StatusOr<FrameView> MakeFrameView(const Camera& camera, int width, int height) {
  FrameView view;
  view.perspective = camera.perspective;
  view.width = width;
  view.height = height;
  view.znear = camera.znear;
  view.zfar = camera.zfar;
  view.center_x = 0.5 * width;
  view.center_y = 0.5 * height;
  SL_RETURN_IF_ERROR(Require(std::isfinite(camera.znear), "znear", camera.znear, "finite"));
  SL_RETURN_IF_ERROR(Require(std::isfinite(camera.zfar), "zfar", camera.zfar, "finite"));
  const std::string beyond_near = absl::StrCat("larger than znear (", camera.znear, ")");
  if (camera.perspective) {
    SL_RETURN_IF_ERROR(Require(camera.yfov > 0 && camera.yfov < std::numbers::pi, "yfov", camera.yfov,
                               "between 0 and pi radians"));
    SL_RETURN_IF_ERROR(Require(camera.znear >= kLeastNear, "znear", camera.znear, "at least 1e-100"));
    SL_RETURN_IF_ERROR(
        Require(camera.zfar == 0 || camera.zfar > camera.znear, "zfar", camera.zfar, beyond_near));
    view.scale_y = 0.5 * height / std::tan(0.5 * camera.yfov);
  } else {
    SL_RETURN_IF_ERROR(
        Require(camera.xmag > 0 && std::isfinite(camera.xmag), "xmag", camera.xmag, "positive"));
    SL_RETURN_IF_ERROR(
        Require(camera.ymag > 0 && std::isfinite(camera.ymag), "ymag", camera.ymag, "positive"));
    SL_RETURN_IF_ERROR(Require(camera.znear >= 0, "znear", camera.znear, "at least 0"));
    SL_RETURN_IF_ERROR(Require(camera.zfar > camera.znear, "zfar", camera.zfar, beyond_near));
    view.scale_y = std::min(0.5 * width / camera.xmag, 0.5 * height / camera.ymag);
  }
  view.scale_x = view.scale_y;
  return view;
}

}  // namespace shutterline::engine
