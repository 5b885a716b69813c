#include "worker/engine/scene/gltf_light.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "common/base/status_macros.h"
#include "worker/engine/scene/gltf_document.h"

namespace shutterline::engine {
namespace {

using Json = nlohmann::json;

constexpr float kRightAngle = float(std::numbers::pi / 2);

absl::Status ReadCones(const Json& in, PunctualLight* light) {
  const auto spot = in.find("spot");
  if (spot == in.end()) return absl::InvalidArgumentError("a spot without the property spot");
  light->inner_cone = spot->value("innerConeAngle", light->inner_cone);
  light->outer_cone = spot->value("outerConeAngle", light->outer_cone);
  // In single precision, in which files have them: a right angle is a little more than pi / 2 there.
  if (!(light->outer_cone > 0 && light->outer_cone <= kRightAngle)) {
    return absl::InvalidArgumentError(
        absl::StrCat("outerConeAngle ", light->outer_cone, " is not above 0 and at most pi / 2"));
  }
  if (!(light->inner_cone >= 0 && light->inner_cone <= light->outer_cone)) {
    return absl::InvalidArgumentError(absl::StrCat("innerConeAngle ", light->inner_cone,
                                                   " is not from 0 to outerConeAngle ", light->outer_cone));
  }
  return absl::OkStatus();
}

absl::StatusOr<PunctualLight> ReadLight(const Json& in) {
  PunctualLight light;
  light.name = in.value("name", "");
  const auto& type = in["type"].get_ref<const std::string&>();
  light.kind = type == "directional" ? PunctualLight::Kind::kDirectional
               : type == "spot"      ? PunctualLight::Kind::kSpot
                                     : PunctualLight::Kind::kPoint;
  if (const auto color = in.find("color"); color != in.end()) {
    for (int i = 0; i < 3; ++i) {
      light.color[i] = (*color)[size_t(i)].get<float>();
      if (light.color[i] < 0)
        return absl::InvalidArgumentError(absl::StrCat("color ", light.color[i], " is negative"));
    }
  }
  light.intensity = in.value("intensity", light.intensity);
  if (light.intensity < 0)
    return absl::InvalidArgumentError(absl::StrCat("intensity ", light.intensity, " is negative"));
  if (const auto range = in.find("range"); range != in.end()) {
    light.range = range->get<float>();
    if (!(light.range > 0))
      return absl::InvalidArgumentError(absl::StrCat("range ", light.range, " is not above 0"));
  }
  if (light.kind == PunctualLight::Kind::kSpot) SL_RETURN_IF_ERROR(ReadCones(in, &light));
  return light;
}

}  // namespace

absl::StatusOr<std::vector<PunctualLight>> ReadGltfLights(const Json& conforming) {
  std::vector<PunctualLight> lights;
  const Json::json_pointer place("/extensions/KHR_lights_punctual/lights");
  if (!conforming.contains(place)) return lights;
  const Json& in = conforming[place];
  for (size_t i = 0; i < in.size(); ++i) {
    absl::StatusOr<PunctualLight> light = ReadLight(in[i]);
    if (!light.ok()) return Annotate(light.status(), GltfElement("light", i, in[i].value("name", "")));
    lights.push_back(*std::move(light));
  }
  return lights;
}

}  // namespace shutterline::engine
