#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace shutterline {

/// Writes small glTF files for tests. `json` is the document and may be edited in any way, also wrongly;
/// the functions below add to it and to the one buffer. Nothing is checked.
///
///   GltfBuilder file;
///   const int positions = file.Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
///   file.Draw(file.Mesh({{"attributes", {{"POSITION", positions}}}}));
///   MemoryAssetSource source("a.glb", {{"a.glb", file.Glb()}});
class GltfBuilder {
 public:
  GltfBuilder();

  nlohmann::json json;
  std::string buffer;

  /// Bytes into the buffer, aligned to 4; the number of their view.
  int View(const std::string& bytes, int stride = 0);

  /// An accessor over its own view; the number of the accessor. `values` are all components.
  template <typename Component>
  int Accessor(const char* type, int component_type, const std::vector<Component>& values,
               bool normalized = false) {
    const std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Component));
    return AccessorOn(View(bytes), 0, type, component_type, values.size() / Components(type), normalized);
  }
  int AccessorOn(int view, int offset, const char* type, int component_type, size_t count,
                 bool normalized = false);
  int Floats(const char* type, const std::vector<float>& values) { return Accessor(type, 5126, values); }
  int Indices(const std::vector<uint16_t>& values) { return Accessor("SCALAR", 5123, values); }

  /// Appends to one of the document's arrays; the element's number.
  int Add(const char* array, nlohmann::json element);
  int Mesh(nlohmann::json primitive);
  /// A node with this mesh, listed in scene 0.
  int Draw(int mesh);
  /// The three corners (0,0,0), (1,0,0), (0,1,0), drawn by a node; the node's number.
  int DrawTriangle();

  /// The finished file. `Glb` describes the buffer where `json` does not; `Gltf` carries the buffer as a data
  /// URI; `GltfWith` names it.
  std::string Glb() const;
  std::string Gltf() const;
  std::string GltfWith(const std::string& buffer_uri) const;

  static size_t Components(const std::string& type);
  static std::string Base64(const std::string& bytes);
};

}  // namespace shutterline
