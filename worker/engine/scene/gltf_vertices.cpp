#include "worker/engine/scene/gltf_vertices.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <cmath>
#include <map>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/gltf_accessor.h"

namespace shutterline::engine {
namespace {

using Attributes = std::map<std::string, int>;

bool IsFinite(const float* values, int count) {
  for (int i = 0; i < count; ++i) {
    if (!std::isfinite(values[i])) return false;
  }
  return true;
}

/// Reads an attribute into an array of Imath vectors of its width.
template <typename Vector>
absl::Status ReadVectors(GltfDocument* document, int accessor, absl::string_view role,
                         std::vector<Vector>* out) {
  const size_t count = document->model.accessors[size_t(accessor)].count;
  const std::string element = GltfAccessorElement(accessor, role);
  SL_RETURN_IF_ERROR(document->memory.Take(count * sizeof(Vector), element));
  out->resize(count);
  if (count == 0) return absl::OkStatus();
  return Annotate(ReadGltfFloats(*document, accessor, &(*out)[0].x), role);
}

/// Zeroes what is not finite, with a warning.
template <typename Vector>
void ZeroWhatIsNotFinite(GltfDocument* document, absl::string_view element, absl::string_view role,
                         std::vector<Vector>* values) {
  size_t bad = 0, first = 0;
  for (size_t i = 0; i < values->size(); ++i) {
    if (IsFinite(&(*values)[i].x, int(Vector::dimensions()))) continue;
    if (bad++ == 0) first = i;
    (*values)[i] = Vector(0.0f);
  }
  if (bad > 0) {
    document->Warn(absl::StrCat(element, ": ", role, " of ", bad, " vertices, the first of them ", first,
                                ", is not finite and taken as 0"));
  }
}

absl::Status ReadColors(GltfDocument* document, int accessor, std::vector<V4f>* out) {
  if (document->model.accessors[size_t(accessor)].type == TINYGLTF_TYPE_VEC4) {
    return ReadVectors(document, accessor, "COLOR_0", out);
  }
  std::vector<V3f> rgb;
  SL_RETURN_IF_ERROR(ReadVectors(document, accessor, "COLOR_0", &rgb));
  SL_RETURN_IF_ERROR(
      document->memory.Take(rgb.size() * sizeof(V4f), GltfAccessorElement(accessor, "COLOR_0")));
  out->reserve(rgb.size());
  for (const V3f& c : rgb) out->push_back(V4f(c.x, c.y, c.z, 1));
  return absl::OkStatus();
}

/// Scales weights to sum 1. Slots of weight 0 lose their joint, so that only joints that move the vertex
/// are held against the skin. Returns false for weights without a sum: the first joint then takes all.
bool NormalizeWeights(VertexInfluences* influences) {
  double sum = 0;
  for (const float w : influences->weights) sum += w;
  if (!(sum > 0)) {
    influences->weights = {1, 0, 0, 0, 0, 0, 0, 0};
    for (size_t i = 1; i < 8; ++i) influences->joints[i] = 0;
    return false;
  }
  for (size_t i = 0; i < 8; ++i) {
    if (sum != 1.0) influences->weights[i] = float(influences->weights[i] / sum);
    if (influences->weights[i] == 0) influences->joints[i] = 0;
  }
  return true;
}

absl::Status ReadInfluences(GltfDocument* document, const Attributes& attributes, absl::string_view element,
                            MeshPrimitive* out, std::vector<bool>* finite) {
  const size_t count = out->positions.size();
  std::vector<uint32_t> joints;
  std::vector<V4f> weights;
  for (size_t set = 0; set < 2; ++set) {
    const auto joint_entry = attributes.find(absl::StrCat("JOINTS_", set));
    if (joint_entry == attributes.end()) continue;
    const std::string role = joint_entry->first;
    const uint64_t bytes =
        count * (4 * sizeof(uint32_t) + (out->influences.empty() ? sizeof(VertexInfluences) : 0));
    SL_RETURN_IF_ERROR(document->memory.Take(bytes, GltfAccessorElement(joint_entry->second, role)));
    out->influences.resize(count);
    joints.resize(count * 4);
    SL_RETURN_IF_ERROR(Annotate(ReadGltfUints(*document, joint_entry->second, joints.data()), role));
    const auto weight_entry = attributes.find(absl::StrCat("WEIGHTS_", set));
    SL_RETURN_IF_ERROR(ReadVectors(document, weight_entry->second, weight_entry->first, &weights));
    for (size_t v = 0; v < count; ++v) {
      for (size_t i = 0; i < 4; ++i) {
        const uint32_t joint = joints[4 * v + i];
        const float weight = weights[v][int(i)];
        if (weight != 0 && joint > UINT16_MAX) {
          return absl::InvalidArgumentError(absl::StrCat(GltfAccessorElement(joint_entry->second, role),
                                                         ": joint ", joint, " of vertex ", v,
                                                         " is out of range"));
        }
        out->influences[v].joints[4 * set + i] = uint16_t(joint);
        out->influences[v].weights[4 * set + i] = weight;
      }
    }
  }
  size_t without = 0;
  for (size_t v = 0; v < out->influences.size(); ++v) {
    VertexInfluences& influences = out->influences[v];
    if (!IsFinite(influences.weights.data(), 8)) {
      (*finite)[v] = false;
      influences.weights = {};
    }
    if (!NormalizeWeights(&influences) && (*finite)[v]) ++without;
  }
  if (without > 0) {
    document->Warn(absl::StrCat(element, ": ", without,
                                " vertices with joint weights of no sum follow their first joint"));
  }
  return absl::OkStatus();
}

absl::Status ReadTargets(GltfDocument* document, const tinygltf::Primitive& primitive,
                         absl::string_view element, MeshPrimitive* out, std::vector<bool>* finite) {
  for (size_t t = 0; t < primitive.targets.size(); ++t) {
    CheckWork();
    MorphTarget target;
    for (const auto& [name, accessor] : primitive.targets[t]) {
      if (name == "POSITION") {
        SL_RETURN_IF_ERROR(
            ReadVectors(document, accessor, absl::StrCat("target ", t, " POSITION"), &target.positions));
      } else if (name == "NORMAL" && !out->normals.empty()) {
        SL_RETURN_IF_ERROR(
            ReadVectors(document, accessor, absl::StrCat("target ", t, " NORMAL"), &target.normals));
        ZeroWhatIsNotFinite(document, element, absl::StrCat("target ", t, " NORMAL"), &target.normals);
      }
    }
    for (size_t v = 0; v < target.positions.size(); ++v) {
      if (!IsFinite(target.positions[v].getValue(), 3)) (*finite)[v] = false;
    }
    out->targets.push_back(std::move(target));
  }
  return absl::OkStatus();
}

/// What an attribute of this name must be; no types where any are allowed, as of a target's tangents, which
/// are not read.
GltfAccessorNeed NeedOf(absl::string_view name, bool of_target) {
  GltfAccessorNeed need{name, {}, {}};
  if (name == "POSITION" || name == "NORMAL") {
    need.types = {TINYGLTF_TYPE_VEC3};
  } else if (name == "TEXCOORD_0" || name == "TEXCOORD_1") {
    need.types = {TINYGLTF_TYPE_VEC2};
  } else if (name == "COLOR_0") {
    need.types = {TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
  } else if (name == "TANGENT" && !of_target) {
    need.types = {TINYGLTF_TYPE_VEC4};
  } else if (absl::StartsWith(name, "WEIGHTS_")) {
    need.types = {TINYGLTF_TYPE_VEC4};
  } else if (absl::StartsWith(name, "JOINTS_")) {
    need.types = {TINYGLTF_TYPE_VEC4};
    need.component_types = {TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                            TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT};
  }
  return need;
}

absl::Status CheckAttributes(const GltfDocument& document, const Attributes& attributes, bool of_target,
                             uint64_t count) {
  for (const auto& [name, accessor] : attributes) {
    if (const GltfAccessorNeed need = NeedOf(name, of_target); !need.types.empty()) {
      SL_RETURN_IF_ERROR(CheckGltfAccessorType(document, accessor, need));
    }
    if (const uint64_t other = document.model.accessors[size_t(accessor)].count; other != count) {
      return absl::InvalidArgumentError(
          absl::StrCat(GltfAccessorElement(accessor, name), ": count ", other, " is not POSITION's ", count));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckGltfPrimitive(const GltfDocument& document, const tinygltf::Primitive& primitive) {
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) return absl::OkStatus();
  const uint64_t count = document.model.accessors[size_t(position->second)].count;
  SL_RETURN_IF_ERROR(CheckAttributes(document, primitive.attributes, false, count));
  for (int set = 0; set < 2; ++set) {
    if (primitive.attributes.count(absl::StrCat("JOINTS_", set)) !=
        primitive.attributes.count(absl::StrCat("WEIGHTS_", set))) {
      return absl::InvalidArgumentError(
          absl::StrCat("JOINTS_", set, " and WEIGHTS_", set, " need each other"));
    }
  }
  for (size_t t = 0; t < primitive.targets.size(); ++t) {
    SL_RETURN_IF_ERROR(
        Annotate(CheckAttributes(document, primitive.targets[t], true, count), absl::StrCat("target ", t)));
  }
  if (primitive.indices < 0) return absl::OkStatus();
  return CheckGltfAccessorType(
      document, primitive.indices,
      {"indices",
       {TINYGLTF_TYPE_SCALAR},
       {TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
        TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT}});
}

absl::Status ReadGltfVertices(GltfDocument* document, const tinygltf::Primitive& primitive,
                              absl::string_view element, MeshPrimitive* out, std::vector<bool>* finite) {
  const Attributes& attributes = primitive.attributes;
  SL_RETURN_IF_ERROR(ReadVectors(document, attributes.at("POSITION"), "POSITION", &out->positions));
  finite->assign(out->positions.size(), true);
  for (size_t v = 0; v < out->positions.size(); ++v) {
    (*finite)[v] = IsFinite(out->positions[v].getValue(), 3);
  }
  if (const auto found = attributes.find("NORMAL"); found != attributes.end()) {
    SL_RETURN_IF_ERROR(ReadVectors(document, found->second, "NORMAL", &out->normals));
    ZeroWhatIsNotFinite(document, element, "NORMAL", &out->normals);
  }
  for (size_t set = 0; set < 2; ++set) {
    const std::string name = absl::StrCat("TEXCOORD_", set);
    const auto found = attributes.find(name);
    if (found == attributes.end()) continue;
    SL_RETURN_IF_ERROR(ReadVectors(document, found->second, name, &out->texcoords[set]));
    ZeroWhatIsNotFinite(document, element, name, &out->texcoords[set]);
  }
  if (const auto found = attributes.find("COLOR_0"); found != attributes.end()) {
    SL_RETURN_IF_ERROR(ReadColors(document, found->second, &out->colors));
    ZeroWhatIsNotFinite(document, element, "COLOR_0", &out->colors);
  }
  if (attributes.count("JOINTS_2") > 0) {
    document->Warn(absl::StrCat(element, ": joints beyond the first 8 of a vertex are ignored"));
  }
  SL_RETURN_IF_ERROR(ReadInfluences(document, attributes, element, out, finite));
  return ReadTargets(document, primitive, element, out, finite);
}

absl::Status ReadGltfTangents(GltfDocument* document, const tinygltf::Primitive& primitive,
                              absl::string_view element, MeshPrimitive* out) {
  const auto found = primitive.attributes.find("TANGENT");
  if (found == primitive.attributes.end() || out->normals.empty()) return absl::OkStatus();
  std::vector<V4f> tangents;
  SL_RETURN_IF_ERROR(ReadVectors(document, found->second, "TANGENT", &tangents));
  ZeroWhatIsNotFinite(document, element, "TANGENT", &tangents);
  SL_RETURN_IF_ERROR(document->memory.Take(3 * out->triangles.size() * sizeof(V4f),
                                           GltfAccessorElement(found->second, "TANGENT")));
  for (V4f& tangent : tangents) tangent.w = tangent.w < 0 ? -1.f : 1.f;
  out->tangents.reserve(3 * out->triangles.size());
  for (const std::array<uint32_t, 3>& triangle : out->triangles) {
    for (const uint32_t vertex : triangle) out->tangents.push_back(tangents[vertex]);
  }
  return absl::OkStatus();
}

}  // namespace shutterline::engine
