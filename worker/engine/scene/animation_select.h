#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <optional>
#include <vector>

#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// The channels that `animation` selects, in the file's order: an animation's name, else its index in
/// decimal digits, else "all" or "none"; empty selects the first animation, or nothing where the file has
/// none. Where several channels animate the same property, the last one wins. INVALID_ARGUMENT, listing
/// the animations that there are, where nothing matches. The pointers live as long as `scene`.
absl::StatusOr<std::vector<const AnimationChannel*>> SelectChannels(const Scene& scene,
                                                                    absl::string_view animation);

/// The number that `word` spells with decimal digits alone, if it is below `count`.
std::optional<int> ParseIndex(absl::string_view word, size_t count);

}  // namespace shutterline::engine
