#pragma once

#include <string>

#include "common/job/render_settings.h"

namespace shutterline {

/// How a picture is made, in the words and numbers of the settings that its integrator uses: "integrator=line
/// size=1024x768 ... pattern=rgls resolver=slice time_step=2". Without the names of camera and animation.
std::string DescribeSettings(const RenderSettings& settings);

}  // namespace shutterline
