#include "worker/engine/scene/animation_select.h"

#include <absl/strings/str_cat.h>

#include <string>

namespace shutterline::engine {
namespace {

void Append(const Animation& animation, std::vector<const AnimationChannel*>& channels) {
  for (const AnimationChannel& channel : animation.channels) {
    if (channel.node >= 0 && !channel.times.empty()) channels.push_back(&channel);
  }
}

std::string ListAnimations(const Scene& scene) {
  if (scene.animations.empty()) return "it has none";
  std::string list = "it has ";
  for (size_t i = 0; i < scene.animations.size(); ++i) {
    absl::StrAppend(&list, i > 0 ? ", " : "", i, " \"", scene.animations[i].name, "\"");
  }
  return list;
}

}  // namespace

std::optional<int> ParseIndex(absl::string_view word, size_t count) {
  if (word.empty() || word.size() > 9) return std::nullopt;
  int value = 0;
  for (const char c : word) {
    if (c < '0' || c > '9') return std::nullopt;
    value = 10 * value + (c - '0');
  }
  if (size_t(value) >= count) return std::nullopt;
  return value;
}

absl::StatusOr<std::vector<const AnimationChannel*>> SelectChannels(const Scene& scene,
                                                                    absl::string_view animation) {
  std::vector<const AnimationChannel*> channels;
  if (animation.empty()) {
    if (!scene.animations.empty()) Append(scene.animations.front(), channels);
    return channels;
  }
  for (const Animation& candidate : scene.animations) {
    if (absl::string_view(candidate.name) == animation) {
      Append(candidate, channels);
      return channels;
    }
  }
  if (const std::optional<int> index = ParseIndex(animation, scene.animations.size())) {
    Append(scene.animations[size_t(*index)], channels);
    return channels;
  }
  if (animation == "none") return channels;
  if (animation == "all") {
    for (const Animation& each : scene.animations) Append(each, channels);
    return channels;
  }
  return absl::InvalidArgumentError(absl::StrCat("scene ", scene.name, " has no animation \"", animation,
                                                 "\": ", ListAnimations(scene),
                                                 "; \"all\" and \"none\" work too"));
}

}  // namespace shutterline::engine
