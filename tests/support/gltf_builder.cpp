#include "tests/support/gltf_builder.h"

#include <absl/strings/escaping.h>

#include <map>

namespace shutterline {
namespace {

using Json = nlohmann::json;

void AppendUint32(std::string* out, size_t value) {
  for (int i = 0; i < 4; ++i) out->push_back(char(value >> (8 * i)));
}

void AppendChunk(std::string* out, size_t type, std::string data, char padding) {
  while (data.size() % 4 != 0) data.push_back(padding);
  AppendUint32(out, data.size());
  AppendUint32(out, type);
  *out += data;
}

}  // namespace

GltfBuilder::GltfBuilder() {
  json["asset"] = {{"version", "2.0"}};
}

int GltfBuilder::View(const std::string& bytes, int stride) {
  while (buffer.size() % 4 != 0) buffer.push_back('\0');
  Json view = {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}};
  if (stride != 0) view["byteStride"] = stride;
  buffer += bytes;
  return Add("bufferViews", std::move(view));
}

int GltfBuilder::AccessorOn(int view, int offset, const char* type, int component_type, size_t count,
                            bool normalized) {
  Json accessor = {{"type", type}, {"componentType", component_type}, {"count", count}};
  if (view >= 0) accessor["bufferView"] = view;
  if (offset != 0) accessor["byteOffset"] = offset;
  if (normalized) accessor["normalized"] = true;
  return Add("accessors", std::move(accessor));
}

int GltfBuilder::Add(const char* array, Json element) {
  json[array].push_back(std::move(element));
  return int(json[array].size()) - 1;
}

int GltfBuilder::Mesh(Json primitive) {
  return Add("meshes", {{"primitives", Json::array({std::move(primitive)})}});
}

int GltfBuilder::Draw(int mesh) {
  const int node = Add("nodes", {{"mesh", mesh}});
  json["scenes"][0]["nodes"].push_back(node);
  return node;
}

int GltfBuilder::DrawTriangle() {
  const int positions = Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  return Draw(Mesh({{"attributes", {{"POSITION", positions}}}}));
}

std::string GltfBuilder::Glb() const {
  Json document = json;
  if (!buffer.empty() && !document.contains("buffers"))
    document["buffers"][0] = {{"byteLength", buffer.size()}};
  std::string chunks;
  AppendChunk(&chunks, 0x4E4F534A, document.dump(), ' ');
  if (!buffer.empty()) AppendChunk(&chunks, 0x004E4942, buffer, '\0');
  std::string file = "glTF";
  AppendUint32(&file, 2);
  AppendUint32(&file, 12 + chunks.size());
  return file + chunks;
}

std::string GltfBuilder::Gltf() const {
  return GltfWith("data:application/octet-stream;base64," + Base64(buffer));
}

std::string GltfBuilder::GltfWith(const std::string& buffer_uri) const {
  Json document = json;
  document["buffers"][0] = {{"byteLength", buffer.size()}, {"uri", buffer_uri}};
  return document.dump();
}

size_t GltfBuilder::Components(const std::string& type) {
  static const std::map<std::string, size_t> components = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  return components.at(type);
}

std::string GltfBuilder::Base64(const std::string& bytes) {
  return absl::Base64Escape(bytes);
}

}  // namespace shutterline
