#include "worker/engine/scene/gltf_camera.h"

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace shutterline::engine {
namespace {

constexpr double kPi = 3.14159265358979323846;

absl::Status ReadPerspective(const tinygltf::PerspectiveCamera& in, Camera* camera) {
  camera->perspective = true;
  camera->yfov = in.yfov;
  camera->aspect_ratio = in.aspectRatio;
  camera->znear = in.znear;
  camera->zfar = in.zfar;
  if (!(in.yfov > 0 && in.yfov < kPi)) {
    return absl::InvalidArgumentError(absl::StrCat("yfov ", in.yfov, " is not between 0 and pi"));
  }
  if (in.aspectRatio < 0)
    return absl::InvalidArgumentError(absl::StrCat("aspectRatio ", in.aspectRatio, " is negative"));
  if (!(in.znear > 0)) return absl::InvalidArgumentError(absl::StrCat("znear ", in.znear, " is not above 0"));
  if (in.zfar != 0 && !(in.zfar > in.znear)) {
    return absl::InvalidArgumentError(absl::StrCat("zfar ", in.zfar, " is not above znear ", in.znear));
  }
  return absl::OkStatus();
}

absl::Status ReadOrthographic(const tinygltf::OrthographicCamera& in, Camera* camera) {
  camera->perspective = false;
  camera->xmag = in.xmag;
  camera->ymag = in.ymag;
  camera->znear = in.znear;
  camera->zfar = in.zfar;
  if (!(in.xmag > 0 && in.ymag > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("xmag ", in.xmag, " or ymag ", in.ymag, " is not above 0"));
  }
  if (!(in.znear >= 0)) return absl::InvalidArgumentError(absl::StrCat("znear ", in.znear, " is negative"));
  if (!(in.zfar > in.znear)) {
    return absl::InvalidArgumentError(absl::StrCat("zfar ", in.zfar, " is not above znear ", in.znear));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ImportGltfCameras(GltfDocument* document, Scene* scene) {
  for (size_t c = 0; c < document->model.cameras.size(); ++c) {
    const tinygltf::Camera& in = document->model.cameras[c];
    Camera camera;
    camera.name = in.name;
    SL_RETURN_IF_ERROR(Annotate(in.type == "perspective" ? ReadPerspective(in.perspective, &camera)
                                                         : ReadOrthographic(in.orthographic, &camera),
                                GltfElement("camera", c, in.name)));
    scene->cameras.push_back(std::move(camera));
  }
  return absl::OkStatus();
}

}  // namespace shutterline::engine
