#include "tests/scenes/glb_writer.h"

#include <bit>
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

json MaterialJson(const Material& material) {
  json result = {{"name", material.name},
                 {"pbrMetallicRoughness",
                  {{"baseColorFactor", {material.color.x, material.color.y, material.color.z, 1}},
                   {"metallicFactor", 0},
                   {"roughnessFactor", 1}}}};
  if (material.unlit) result["extensions"]["KHR_materials_unlit"] = json::object();
  if (material.double_sided) result["doubleSided"] = true;
  return result;
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
  bool unlit = false;
  for (const Material& material : scene.materials) {
    root["materials"].push_back(MaterialJson(material));
    unlit = unlit || material.unlit;
  }
  if (unlit) root["extensionsUsed"] = {"KHR_materials_unlit"};
  for (const Mesh& mesh : scene.meshes) {
    root["meshes"].push_back(MeshJson(mesh, scene.materials.size(), buffer));
  }
  for (const Node& node : scene.nodes) {
    SL_CHECK(node.mesh < int(scene.meshes.size()) && node.camera < int(scene.cameras.size()));
    root["nodes"].push_back(NodeJson(node));
  }
  for (const Camera& camera : scene.cameras) {
    root["cameras"].push_back(
        {{"type", "perspective"},
         {"perspective",
          {{"yfov", camera.yfov}, {"aspectRatio", camera.aspect_ratio}, {"znear", camera.znear}}}});
  }
  if (!scene.channels.empty()) root["animations"].push_back(AnimationJson(scene, buffer));
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
