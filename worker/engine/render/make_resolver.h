#pragma once

#include <memory>

#include "common/job/render_settings.h"
#include "worker/engine/visibility/resolver.h"

namespace shutterline::engine {

/// The resolver that `settings.resolver` names, for the pattern that it names.
std::unique_ptr<const Resolver> MakeResolver(const RenderSettings& settings);

}  // namespace shutterline::engine
