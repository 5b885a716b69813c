#include "worker/engine/scene/frame_light.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "common/math/unit_vector.h"
#include "worker/engine/scene/pose.h"

namespace shutterline::engine {
namespace {

/// Colour times intensity; both fit a float, their product may not.
V3f Scaled(const V3f& color, float intensity) {
  V3f scaled;
  for (int i = 0; i < 3; ++i)
    scaled[i] = float(std::min(double(color[i]) * double(intensity), double(FLT_MAX)));
  return scaled;
}

}  // namespace

std::vector<FrameLight> PlaceLights(const Scene& scene, const Moment& moment,
                                    std::vector<std::string>& warnings) {
  std::vector<FrameLight> lights;
  for (const int index : NodesInDefaultScene(scene)) {
    const Node& node = scene.nodes[size_t(index)];
    if (node.light < 0) continue;
    const PunctualLight& in = scene.lights[size_t(node.light)];
    const M44d view = moment.camera.ViewFrom(moment.pose.world_from_node[size_t(index)]);
    FrameLight light;
    light.kind = in.kind;
    light.position = V3d(view[3][0], view[3][1], view[3][2]);
    light.direction = UnitOrZero(-V3d(view[2][0], view[2][1], view[2][2]));
    light.intensity = Scaled(in.color, in.intensity);
    light.range = in.range;
    light.cos_inner = std::cos(double(in.inner_cone));
    light.cos_outer = std::cos(double(in.outer_cone));
    const double sum = light.position.x + light.position.y + light.position.z;
    const bool needs_direction = in.kind != PunctualLight::Kind::kPoint;
    const bool needs_position = in.kind != PunctualLight::Kind::kDirectional;
    if ((needs_position && !std::isfinite(sum)) || (needs_direction && light.direction == V3d(0))) {
      warnings.push_back(absl::StrCat("node ", index, " \"", node.name, "\", light ", node.light, " \"",
                                      in.name, "\": it has no place or no direction and is left out"));
      continue;
    }
    lights.push_back(light);
  }
  return lights;
}

}  // namespace shutterline::engine
