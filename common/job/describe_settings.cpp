#include "common/job/describe_settings.h"

#include <absl/strings/str_cat.h>

namespace shutterline {

std::string DescribeSettings(const RenderSettings& s) {
  std::string text = absl::StrCat("integrator=", ToString(s.integrator), " size=", s.width, "x", s.height,
                                  " fps=", s.fps, " shutter=", s.shutter_open, ":", s.shutter_close);
  for (size_t i = 0; i < s.shutter_curve.size(); ++i) {
    absl::StrAppend(&text, i == 0 ? " shutter_curve=" : ",", s.shutter_curve[i].time, ":",
                    s.shutter_curve[i].opening);
  }
  if (s.motion_degree) absl::StrAppend(&text, " motion_degree=", *s.motion_degree);
  if (s.motion_pieces) absl::StrAppend(&text, " motion_pieces=", *s.motion_pieces);
  absl::StrAppend(&text, " lighting=", ToString(s.lighting));
  if (s.ambient != std::array<double, 3>{0, 0, 0}) {
    absl::StrAppend(&text, " ambient=", s.ambient[0], ",", s.ambient[1], ",", s.ambient[2]);
  }
  if (s.occlusion) {
    absl::StrAppend(&text, " occlusion=", ToString(s.occlusion->pattern), ",lines:", s.occlusion->lines);
    if (s.occlusion->radius) {
      absl::StrAppend(&text, ",radius:", *s.occlusion->radius, ",falloff:", ToString(s.occlusion->falloff));
    }
    absl::StrAppend(&text, ",motion:", s.occlusion->motion ? "on" : "off");
  }
  if (s.shading_rate) absl::StrAppend(&text, " shading_rate=", *s.shading_rate);
  if (s.cache_propagate) absl::StrAppend(&text, " cache_propagate=on");
  absl::StrAppend(&text, " filter=", ToString(s.filter), ",radius:", FilterRadius(s));
  if (s.integrator == IntegratorKind::kLine) {
    absl::StrAppend(&text, " pattern=", ToString(s.pattern), " resolver=", ToString(s.resolver));
    if (s.resolver == ResolverKind::kPaper) {
      absl::StrAppend(&text, " time_cells=", s.time_cells);
    } else if (s.time_samples) {
      absl::StrAppend(&text, " time_samples=", *s.time_samples);
    } else {
      absl::StrAppend(&text, " time_step=", s.time_step);
      if (s.target_error) absl::StrAppend(&text, " target_error=", *s.target_error);
    }
  } else {
    absl::StrAppend(&text, " spp=", s.spp, " seed=", s.seed);
    if (s.integrator == IntegratorKind::kReference) {
      absl::StrAppend(&text, " reference_layout=", ToString(s.reference_layout));
    }
  }
  return text;
}

}  // namespace shutterline
