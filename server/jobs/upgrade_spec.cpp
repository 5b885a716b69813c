#include "server/jobs/upgrade_spec.h"

namespace shutterline::server {

void UpgradeSpec(v1::JobSpec& spec) {
  v1::RenderSettings& render = *spec.mutable_render();
  // None of these may be zero in a build that knows it.
  if (render.reference_layout() == v1::REFERENCE_LAYOUT_UNSPECIFIED)
    render.set_reference_layout(v1::REFERENCE_LAYOUT_MOTION_BVH);
  if (render.time_cells() == 0) render.set_time_cells(4);
  if (render.lighting() == v1::LIGHTING_UNSPECIFIED) render.set_lighting(v1::LIGHTING_AUTO);
  if (render.matte_ranks() == 0) render.set_matte_ranks(6);
}

}  // namespace shutterline::server
