#include "worker/engine/scene/gltf_animation.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <optional>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/gltf_accessor.h"

namespace shutterline::engine {
namespace {

std::optional<AnimatedPath> PathOf(absl::string_view word) {
  if (word == "translation") return AnimatedPath::kTranslation;
  if (word == "rotation") return AnimatedPath::kRotation;
  if (word == "scale") return AnimatedPath::kScale;
  if (word == "weights") return AnimatedPath::kWeights;
  return std::nullopt;
}

class ChannelReader {
 public:
  ChannelReader(GltfDocument* document, const Scene& scene, std::string element)
      : document_(*document), scene_(scene), element_(std::move(element)) {}

  /// Nothing where the channel is left out.
  absl::StatusOr<std::optional<AnimationChannel>> Read(
      const tinygltf::AnimationChannel& in, const std::vector<tinygltf::AnimationSampler>& samplers) {
    if (size_t(in.sampler) >= samplers.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat("sampler ", in.sampler, " does not exist: the animation has ", samplers.size()));
    }
    const tinygltf::AnimationSampler& sampler = samplers[size_t(in.sampler)];
    const std::optional<AnimatedPath> path = PathOf(in.target_path);
    if (!path.has_value())
      return LeaveOut(absl::StrCat("path \"", in.target_path.substr(0, 40), "\" is unknown"));
    AnimationChannel channel;
    channel.node = in.target_node;
    channel.path = *path;
    channel.interpolation = sampler.interpolation == "STEP"          ? Interpolation::kStep
                            : sampler.interpolation == "CUBICSPLINE" ? Interpolation::kCubicSpline
                                                                     : Interpolation::kLinear;
    const Node& node = scene_.nodes[size_t(channel.node)];
    if (*path == AnimatedPath::kWeights) {
      channel.width = node.mesh >= 0 ? int(scene_.meshes[size_t(node.mesh)].weights.size()) : 0;
      if (channel.width == 0) return LeaveOut(absl::StrCat("node ", channel.node, " has no morph targets"));
    } else {
      channel.width = *path == AnimatedPath::kRotation ? 4 : 3;
      if (node.transform.has_matrix) return LeaveOut(absl::StrCat("node ", channel.node, " has a matrix"));
    }
    SL_RETURN_IF_ERROR(ReadTimes(sampler.input, &channel));
    SL_RETURN_IF_ERROR(ReadValues(sampler.output, &channel));
    if (*path == AnimatedPath::kRotation) MendZeroRotations(&channel);
    return std::optional(std::move(channel));
  }

 private:
  std::optional<AnimationChannel> LeaveOut(absl::string_view reason) {
    document_.Warn(absl::StrCat(element_, ": left out: ", reason));
    return std::nullopt;
  }

  absl::Status ReadFloats(int accessor, absl::string_view role, int type, std::vector<float>* out) {
    SL_RETURN_IF_ERROR(CheckGltfAccessorType(document_, accessor, {role, {type}}));
    const tinygltf::Accessor& in = document_.model.accessors[size_t(accessor)];
    const uint64_t count = in.count * uint64_t(GltfComponents(in));
    const std::string element = GltfAccessorElement(accessor, role);
    SL_RETURN_IF_ERROR(document_.memory.Take(count * sizeof(float), element));
    out->resize(count);
    SL_RETURN_IF_ERROR(ReadGltfFloats(document_, accessor, out->data()));
    for (size_t i = 0; i < out->size(); ++i) {
      if (!std::isfinite((*out)[i]))
        return absl::InvalidArgumentError(absl::StrCat(element, ": number ", i, " is not finite"));
    }
    return absl::OkStatus();
  }

  absl::Status ReadTimes(int accessor, AnimationChannel* channel) {
    SL_RETURN_IF_ERROR(ReadFloats(accessor, "key times", TINYGLTF_TYPE_SCALAR, &channel->times));
    const std::string element = GltfAccessorElement(accessor, "key times");
    if (channel->times.empty()) return absl::InvalidArgumentError(absl::StrCat(element, ": there are none"));
    for (size_t i = 1; i < channel->times.size(); ++i) {
      if (!(channel->times[i] > channel->times[i - 1])) {
        return absl::InvalidArgumentError(absl::StrCat(element, ": key ", i, " at ", channel->times[i],
                                                       " s is not after ", channel->times[i - 1], " s"));
      }
    }
    if (channel->times[0] < 0) document_.Warn(absl::StrCat(element_, ": its keys begin before time 0"));
    return absl::OkStatus();
  }

  absl::Status ReadValues(int accessor, AnimationChannel* channel) {
    const int type = channel->path == AnimatedPath::kWeights    ? TINYGLTF_TYPE_SCALAR
                     : channel->path == AnimatedPath::kRotation ? TINYGLTF_TYPE_VEC4
                                                                : TINYGLTF_TYPE_VEC3;
    // Elements come before memory: the output must be as long as the input calls for.
    const uint64_t per_key = (channel->interpolation == Interpolation::kCubicSpline ? 3 : 1) *
                             (channel->path == AnimatedPath::kWeights ? uint64_t(channel->width) : 1);
    const uint64_t expected = channel->times.size() * per_key;
    if (const uint64_t count = document_.model.accessors[size_t(accessor)].count; count != expected) {
      return absl::InvalidArgumentError(absl::StrCat(GltfAccessorElement(accessor, "key values"), ": count ",
                                                     count, " is not the ", expected, " that ",
                                                     channel->times.size(), " keys call for"));
    }
    return ReadFloats(accessor, "key values", type, &channel->values);
  }

  void MendZeroRotations(AnimationChannel* channel) {
    const bool cubic = channel->interpolation == Interpolation::kCubicSpline;
    for (size_t key = 0; key < channel->times.size(); ++key) {
      float* q = &channel->values[cubic ? 12 * key + 4 : 4 * key];
      if (double(q[0]) * q[0] + double(q[1]) * q[1] + double(q[2]) * q[2] + double(q[3]) * q[3] > 1e-60)
        continue;
      q[0] = q[1] = q[2] = 0;
      q[3] = 1;
      document_.Warn(absl::StrCat(element_, ": key ", key, ": a rotation of length 0 taken as none"));
    }
  }

  GltfDocument& document_;
  const Scene& scene_;
  const std::string element_;
};

}  // namespace

absl::Status ImportGltfAnimations(GltfDocument* document, Scene* scene) {
  const auto& animations = document->model.animations;
  for (size_t a = 0; a < animations.size(); ++a) {
    Animation animation;
    animation.name = animations[a].name;
    for (size_t c = 0; c < animations[a].channels.size(); ++c) {
      CheckWork();
      const std::string element = absl::StrCat(GltfElement("animation", a, animation.name), " channel ", c);
      auto channel =
          ChannelReader(document, *scene, element).Read(animations[a].channels[c], animations[a].samplers);
      if (!channel.ok()) return Annotate(channel.status(), element);
      if (channel->has_value()) animation.channels.push_back(*std::move(*channel));
    }
    scene->animations.push_back(std::move(animation));
  }
  return absl::OkStatus();
}

}  // namespace shutterline::engine
