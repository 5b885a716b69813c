#include "tests/scenes/glb_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/check.h"

namespace shutterline::scenes {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "GLB is little-endian, and so is this writer");

constexpr int kUnsignedInt = 5125, kFloat = 5126;            // componentType
constexpr int kArrayBuffer = 34962, kElementBuffer = 34963;  // bufferView.target

/// The binary chunk, and the accessors and views that speak of it.
class Buffer {
 public:
  /// One accessor over a tight array of `count` elements of 4-byte components.
  template <typename T>
  int Add(const T* data, size_t count, const char* type, int component, int target) {
    json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", count * sizeof(T)}};
    if (target != 0) view["target"] = target;
    bytes_.append(reinterpret_cast<const char*>(data), count * sizeof(T));
    accessors_.push_back(
        {{"bufferView", views_.size()}, {"componentType", component}, {"count", count}, {"type", type}});
    views_.push_back(std::move(view));
    return int(accessors_.size()) - 1;
  }
  int AddVectors(const std::vector<V3f>& values) {
    return Add(values.data(), values.size(), "VEC3", kFloat, kArrayBuffer);
  }
  /// A view without an accessor, padded so that what follows stays aligned; the view's number.
  int AddBytes(const std::string& bytes) {
    views_.push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}});
    bytes_ += bytes;
    bytes_.append((4 - bytes_.size() % 4) % 4, '\0');
    return int(views_.size()) - 1;
  }
  /// Positions, also a morph target's, must state their bounds.
  int AddPositions(const std::vector<V3f>& values) {
    const int accessor = AddVectors(values);
    Imath::Box3f box;
    for (const V3f& value : values) box.extendBy(value);
    accessors_.back()["min"] = {box.min.x, box.min.y, box.min.z};
    accessors_.back()["max"] = {box.max.x, box.max.y, box.max.z};
    return accessor;
  }
  /// Elements of `width` floats each.
  int AddElements(const std::vector<float>& values, size_t width, const char* type) {
    const int accessor = Add(values.data(), values.size(), type, kFloat, 0);
    accessors_.back()["count"] = values.size() / width;
    return accessor;
  }
  int AddTimes(const std::vector<float>& values) {
    const int accessor = Add(values.data(), values.size(), "SCALAR", kFloat, 0);
    accessors_.back()["min"] = {values.front()};
    accessors_.back()["max"] = {values.back()};
    return accessor;
  }

  const json& accessors() const { return accessors_; }
  const json& views() const { return views_; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  json accessors_ = json::array(), views_ = json::array();
};

/// A whole number as an integer, for files that people read.
json Plain(float value) {
  return value == std::floor(value) && std::abs(value) < 1e6f ? json(int(value)) : json(value);
}

json Triple(const V3f& v) {
  return {v.x, v.y, v.z};
}

/// The file has one texture an image, of the same number.
json TextureJson(const TextureUse& use) {
  json result = {{"index", use.image}};
  json transform = json::object();
  if (use.offset != V2f(0)) transform["offset"] = {use.offset.x, use.offset.y};
  if (use.rotation != 0) transform["rotation"] = use.rotation;
  if (use.scale != V2f(1)) transform["scale"] = {use.scale.x, use.scale.y};
  if (!transform.empty()) result["extensions"]["KHR_texture_transform"] = transform;
  return result;
}

void AddTextures(const Material& material, json& result) {
  json& pbr = result["pbrMetallicRoughness"];
  if (material.color_texture.image >= 0) pbr["baseColorTexture"] = TextureJson(material.color_texture);
  if (material.metallic_roughness_texture.image >= 0) {
    pbr["metallicRoughnessTexture"] = TextureJson(material.metallic_roughness_texture);
  }
  if (material.normal_texture.image >= 0) {
    result["normalTexture"] = TextureJson(material.normal_texture);
    if (material.normal_scale != 1) result["normalTexture"]["scale"] = material.normal_scale;
  }
  if (material.occlusion_texture.image >= 0) {
    result["occlusionTexture"] = TextureJson(material.occlusion_texture);
    if (material.occlusion_strength != 1) {
      result["occlusionTexture"]["strength"] = material.occlusion_strength;
    }
  }
  if (material.emission_texture.image >= 0)
    result["emissiveTexture"] = TextureJson(material.emission_texture);
}

void AddEmission(const Material& material, json& result) {
  if (material.emission == V3f(0)) return;
  // The factor is at most 1; what is above goes into the strength.
  const float strength = std::max({1.f, material.emission.x, material.emission.y, material.emission.z});
  result["emissiveFactor"] = Triple(material.emission / strength);
  if (strength > 1)
    result["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", strength}};
}

json MaterialJson(const Material& material) {
  json result = {
      {"name", material.name},
      {"pbrMetallicRoughness",
       {{"baseColorFactor", {material.color.x, material.color.y, material.color.z, Plain(material.alpha)}},
        {"metallicFactor", Plain(material.metallic)},
        {"roughnessFactor", Plain(material.roughness)}}}};
  if (material.unlit) result["extensions"]["KHR_materials_unlit"] = json::object();
  if (material.double_sided) result["doubleSided"] = true;
  if (material.alpha_mode == AlphaMode::kBlend) result["alphaMode"] = "BLEND";
  if (material.alpha_mode == AlphaMode::kMask) {
    result["alphaMode"] = "MASK";
    result["alphaCutoff"] = material.alpha_cutoff;
  }
  if (material.ior != 1.5f) result["extensions"]["KHR_materials_ior"] = {{"ior", material.ior}};
  if (material.specular != 1 || material.specular_color != V3f(1)) {
    result["extensions"]["KHR_materials_specular"] = {
        {"specularFactor", material.specular}, {"specularColorFactor", Triple(material.specular_color)}};
  }
  AddEmission(material, result);
  AddTextures(material, result);
  return result;
}

json LightJson(const Light& light) {
  const char* type = light.kind == Light::Kind::kDirectional ? "directional"
                     : light.kind == Light::Kind::kPoint     ? "point"
                                                             : "spot";
  json result = {{"type", type}, {"color", Triple(light.color)}, {"intensity", light.intensity}};
  if (light.range > 0) result["range"] = light.range;
  if (light.kind == Light::Kind::kSpot) {
    result["spot"] = {{"innerConeAngle", light.inner_cone}, {"outerConeAngle", light.outer_cone}};
  }
  return result;
}

/// The names of all extensions that objects anywhere in `value` have.
void CollectExtensions(const json& value, std::set<std::string>& names) {
  if (!value.is_structured()) return;
  for (const auto& [key, member] : value.items()) {
    if (value.is_object() && key == "extensions") {
      for (const auto& extension : member.items()) names.insert(extension.key());
    }
    CollectExtensions(member, names);
  }
}

json PrimitiveJson(const Primitive& primitive, size_t materials, Buffer& buffer) {
  SL_CHECK(primitive.material >= 0 && size_t(primitive.material) < materials);
  SL_CHECK(!primitive.triangles.empty());
  const size_t count = primitive.positions.size();
  for (const auto& triangle : primitive.triangles) {
    for (const uint32_t corner : triangle) SL_CHECK(corner < count);
  }
  json result = {{"material", primitive.material},
                 {"attributes", {{"POSITION", buffer.AddPositions(primitive.positions)}}}};
  if (!primitive.normals.empty()) {
    SL_CHECK(primitive.normals.size() == count);
    result["attributes"]["NORMAL"] = buffer.AddVectors(primitive.normals);
  }
  if (!primitive.colors.empty()) {
    SL_CHECK(primitive.colors.size() == count);
    result["attributes"]["COLOR_0"] = buffer.AddVectors(primitive.colors);
  }
  if (!primitive.texcoords.empty()) {
    SL_CHECK(primitive.texcoords.size() == count);
    result["attributes"]["TEXCOORD_0"] =
        buffer.Add(primitive.texcoords.data(), count, "VEC2", kFloat, kArrayBuffer);
  }
  if (!primitive.tangents.empty()) {
    SL_CHECK(primitive.tangents.size() == count);
    result["attributes"]["TANGENT"] =
        buffer.Add(primitive.tangents.data(), count, "VEC4", kFloat, kArrayBuffer);
  }
  if (!primitive.morph_offsets.empty()) {
    SL_CHECK(primitive.morph_offsets.size() == count);
    result["targets"] = {{{"POSITION", buffer.AddPositions(primitive.morph_offsets)}}};
  }
  result["indices"] = buffer.Add(primitive.triangles.front().data(), 3 * primitive.triangles.size(), "SCALAR",
                                 kUnsignedInt, kElementBuffer);
  return result;
}

json MeshJson(const Mesh& mesh, size_t materials, Buffer& buffer) {
  json result = {{"name", mesh.name}, {"primitives", json::array()}};
  SL_CHECK(!mesh.primitives.empty());
  const bool morphs = !mesh.primitives.front().morph_offsets.empty();
  for (const Primitive& primitive : mesh.primitives) {
    SL_CHECK(primitive.morph_offsets.empty() != morphs);
    result["primitives"].push_back(PrimitiveJson(primitive, materials, buffer));
  }
  if (morphs) result["weights"] = {0};
  return result;
}

json NodeJson(const Node& node) {
  json result = {{"name", node.name}};
  if (node.translation != V3f(0)) {
    result["translation"] = {node.translation.x, node.translation.y, node.translation.z};
  }
  if (!(node.rotation == Imath::Quatf())) {
    result["rotation"] = {node.rotation.v.x, node.rotation.v.y, node.rotation.v.z, node.rotation.r};
  }
  if (node.scale != 1) result["scale"] = {node.scale, node.scale, node.scale};
  if (node.mesh >= 0) result["mesh"] = node.mesh;
  if (node.camera >= 0) result["camera"] = node.camera;
  if (!node.children.empty()) result["children"] = node.children;
  if (node.light >= 0) result["extensions"]["KHR_lights_punctual"]["light"] = node.light;
  return result;
}

json AnimationJson(const GlbScene& scene, Buffer& buffer) {
  json result = {{"name", scene.name}, {"channels", json::array()}, {"samplers", json::array()}};
  for (const Channel& channel : scene.channels) {
    const char* path = channel.path == Path::kTranslation ? "translation"
                       : channel.path == Path::kRotation  ? "rotation"
                                                          : "weights";
    const size_t width = channel.path == Path::kTranslation ? 3 : channel.path == Path::kRotation ? 4 : 1;
    const char* type = channel.path == Path::kTranslation ? "VEC3"
                       : channel.path == Path::kRotation  ? "VEC4"
                                                          : "SCALAR";
    SL_CHECK(channel.node >= 0 && size_t(channel.node) < scene.nodes.size());
    SL_CHECK(!channel.times.empty() && channel.values.size() == width * channel.times.size());
    for (size_t i = 1; i < channel.times.size(); ++i) SL_CHECK(channel.times[i - 1] < channel.times[i]);
    result["channels"].push_back(
        {{"sampler", result["samplers"].size()}, {"target", {{"node", channel.node}, {"path", path}}}});
    const int input = buffer.AddTimes(channel.times);
    const int output = buffer.AddElements(channel.values, width, type);
    result["samplers"].push_back({{"input", input}, {"interpolation", "LINEAR"}, {"output", output}});
  }
  return result;
}

std::vector<int> Roots(const GlbScene& scene) {
  std::set<int> children;
  for (const Node& node : scene.nodes) {
    for (const int child : node.children) {
      SL_CHECK(child >= 0 && size_t(child) < scene.nodes.size());
      SL_CHECK(children.insert(child).second);
    }
  }
  std::vector<int> roots;
  for (int i = 0; i < int(scene.nodes.size()); ++i) {
    if (!children.contains(i)) roots.push_back(i);
  }
  return roots;
}

void AppendWord(uint64_t value, std::string& bytes) {
  SL_CHECK(value <= std::numeric_limits<uint32_t>::max());
  const uint32_t word = uint32_t(value);
  bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

}  // namespace

std::string EncodeGlb(const GlbScene& scene) {
  Buffer buffer;
  json root = {{"asset", {{"version", "2.0"}, {"generator", "shutterline-scenes"}}},
               {"scene", 0},
               {"scenes", {{{"name", scene.name}, {"nodes", Roots(scene)}}}}};
  for (const Material& material : scene.materials) {
    for (const TextureUse& use :
         {material.color_texture, material.metallic_roughness_texture, material.normal_texture,
          material.occlusion_texture, material.emission_texture}) {
      SL_CHECK(use.image < int(scene.images.size()));
    }
    root["materials"].push_back(MaterialJson(material));
  }
  for (const Mesh& mesh : scene.meshes) {
    root["meshes"].push_back(MeshJson(mesh, scene.materials.size(), buffer));
  }
  for (const Node& node : scene.nodes) {
    SL_CHECK(node.mesh < int(scene.meshes.size()) && node.camera < int(scene.cameras.size()));
    SL_CHECK(node.light < int(scene.lights.size()));
    root["nodes"].push_back(NodeJson(node));
  }
  for (const Camera& camera : scene.cameras) {
    root["cameras"].push_back(
        {{"type", "perspective"},
         {"perspective",
          {{"yfov", camera.yfov}, {"aspectRatio", camera.aspect_ratio}, {"znear", camera.znear}}}});
  }
  if (!scene.channels.empty()) root["animations"].push_back(AnimationJson(scene, buffer));
  for (const Image& image : scene.images) {
    root["textures"].push_back({{"source", root["images"].size()}});
    root["images"].push_back(
        {{"name", image.name}, {"mimeType", "image/png"}, {"bufferView", buffer.AddBytes(image.png)}});
  }
  for (const Light& light : scene.lights) {
    root["extensions"]["KHR_lights_punctual"]["lights"].push_back(LightJson(light));
  }
  std::set<std::string> extensions;
  CollectExtensions(root, extensions);
  if (!extensions.empty()) root["extensionsUsed"] = extensions;
  root["accessors"] = buffer.accessors();
  root["bufferViews"] = buffer.views();
  root["buffers"].push_back({{"byteLength", buffer.bytes().size()}});

  // A header of 12 bytes, then two chunks of 8 bytes and their data, padded to a multiple of 4.
  std::string text = root.dump();
  text.append((4 - text.size() % 4) % 4, ' ');
  std::string bytes = "glTF";
  AppendWord(2, bytes);
  AppendWord(12 + 8 + text.size() + 8 + buffer.bytes().size(), bytes);
  AppendWord(text.size(), bytes);
  bytes += "JSON" + text;
  AppendWord(buffer.bytes().size(), bytes);
  bytes.append("BIN\0", 4);
  return bytes + buffer.bytes();
}

}  // namespace shutterline::scenes
