#pragma once

#include "common/job/render_stats.h"

namespace shutterline::engine {

using shutterline::RenderStats;

}  // namespace shutterline::engine
