#include "worker/engine/shading/reflect.h"

#include <algorithm>
#include <cmath>

#include "common/math/unit_vector.h"
#include "worker/engine/shading/directional_albedo.h"
#include "worker/engine/shading/ggx.h"
#include "worker/engine/shading/punctual.h"

namespace shutterline::engine {
namespace {

/// How the surface splits light by what it does with it.
struct Shares {
  V3d once;        ///< Mirrored by one facet.
  V3d repeatedly;  ///< Mirrored by several, which scatters it.
  V3d matte;       ///< Scattered within.
  V3d more;        ///< What `once` is multiplied by to have `repeatedly` too.
};

Shares SharesOf(const Surface& surface, double n_dot_v) {
  const DirectionalAlbedo albedo = GgxDirectionalAlbedo(n_dot_v, surface.roughness);
  const double once = albedo.scale + albedo.bias;
  const double rest = 1 - once;
  Shares shares;
  for (int c = 0; c < 3; ++c) {
    const double f0 = surface.f0[c];
    shares.once[c] = f0 * albedo.scale + surface.f90 * albedo.bias;
    // The mean of Schlick's reflectance over the hemisphere.
    const double mean = f0 + (surface.f90 - f0) / 21;
    shares.repeatedly[c] = shares.once[c] * mean * rest / (1 - rest * mean);
    const double mirrored = shares.once[c] + shares.repeatedly[c];
    shares.matte[c] = (1 - mirrored) * (1 - surface.metallic) * surface.base_color[c];
    shares.more[c] = shares.once[c] > 0 ? mirrored / shares.once[c] : 1;
  }
  return shares;
}

V3d FromSky(const FrameView& view, const Lighting& lighting, const Surface& surface, const Shares& shares,
            double n_dot_v) {
  const V3d& n = surface.normal;
  V3d scattered = lighting.ambient;
  V3d mirrored = lighting.ambient;
  if (lighting.sky != nullptr) {
    scattered += lighting.sky->Diffuse(view.WorldFromView(n));
    const V3d reflected = UnitOrZero(2 * n_dot_v * n - surface.to_camera);
    // Rough lobes lean towards the normal, where they are not cut off.
    const double alpha = surface.roughness * surface.roughness;
    const V3d lobe = UnitOrZero(reflected + alpha * (n - reflected));
    mirrored += lighting.sky->Glossy(view.WorldFromView(lobe == V3d(0) ? n : lobe), surface.roughness);
  }
  return surface.occlusion *
         (shares.once * mirrored + shares.repeatedly * scattered + shares.matte * scattered);
}

V3d FromLight(const Incidence& incidence, const Surface& surface, const Shares& shares, double n_dot_v) {
  const double n_dot_l = surface.normal.dot(incidence.to_light);
  if (!(n_dot_l > 0) || !(surface.face.dot(incidence.to_light) > 0)) return V3d(0);
  const V3d half = UnitOrZero(surface.to_camera + incidence.to_light);
  if (half == V3d(0)) return V3d(0);
  const double n_dot_h = std::clamp(surface.normal.dot(half), 0.0, 1.0);
  const double v_dot_h = std::clamp(surface.to_camera.dot(half), 0.0, 1.0);
  const double alpha = std::max(surface.roughness * surface.roughness, kLeastAlpha);
  const double facets = GgxDistribution(n_dot_h, alpha) * SmithVisibility(n_dot_v, n_dot_l, alpha);
  const V3d mirrored = facets * (shares.more * SchlickFresnel(surface.f0, surface.f90, v_dot_h));
  return n_dot_l * (incidence.irradiance * (mirrored + shares.matte / M_PI));
}

}  // namespace

V3d Reflect(const FrameView& view, const Lighting& lighting, const Surface& surface) {
  const double n_dot_v = std::max(surface.normal.dot(surface.to_camera), 1e-4);
  const Shares shares = SharesOf(surface, n_dot_v);
  V3d sum(0);
  if (lighting.HasSky()) sum = FromSky(view, lighting, surface, shares, n_dot_v);
  for (const FrameLight& light : lighting.lights) {
    const auto incidence = IncidenceAt(light, surface.position);
    if (!incidence) continue;
    const V3d radiance = FromLight(*incidence, surface, shares, n_dot_v);
    if (radiance == V3d(0)) continue;
    if (lighting.shadows != nullptr &&
        lighting.shadows->IsShadowed(surface.position, surface.face, incidence->to_light,
                                     incidence->distance)) {
      continue;
    }
    sum += radiance;
  }
  return sum;
}

}  // namespace shutterline::engine
