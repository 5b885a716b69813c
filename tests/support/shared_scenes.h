#pragma once

#include <optional>
#include <string>

namespace shutterline {

/// The optional folder of test scenes: $SHUTTERLINE_SCENES, else ../shared/scenes beside the source tree.
/// Where it is absent, says so loudly on stderr and returns nothing; tests then skip that part.
std::optional<std::string> FindSharedScenes();

}  // namespace shutterline
