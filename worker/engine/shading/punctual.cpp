#include "worker/engine/shading/punctual.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/unit_vector.h"

namespace shutterline::engine {

std::optional<Incidence> IncidenceAt(const FrameLight& light, const V3d& position) {
  Incidence incidence;
  if (light.kind == PunctualLight::Kind::kDirectional) {
    incidence.to_light = -light.direction;
    incidence.distance = std::numeric_limits<double>::infinity();
    incidence.irradiance = V3d(light.intensity);
    return incidence;
  }
  const V3d offset = light.position - position;
  const double squared = offset.dot(offset);
  incidence.to_light = UnitOrZero(offset);
  if (incidence.to_light == V3d(0) || !(squared > 0) || !std::isfinite(squared)) return std::nullopt;
  incidence.distance = std::sqrt(squared);
  double share = 1 / squared;
  if (light.range > 0) {
    // The window that the extension recommends.
    const double part = incidence.distance / light.range;
    const double window = 1 - part * part * part * part;
    if (window <= 0) return std::nullopt;
    share *= std::min(window, 1.0);
  }
  if (light.kind == PunctualLight::Kind::kSpot) {
    const double cosine = -light.direction.dot(incidence.to_light);
    const double width = std::max(light.cos_inner - light.cos_outer, 1e-3);
    const double inside = std::clamp((cosine - light.cos_outer) / width, 0.0, 1.0);
    if (inside == 0) return std::nullopt;
    share *= inside * inside;
  }
  incidence.irradiance = share * V3d(light.intensity);
  return incidence;
}

}  // namespace shutterline::engine
