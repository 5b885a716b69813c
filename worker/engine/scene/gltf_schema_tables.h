#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>
#include <initializer_list>
#include <vector>

/// The properties of glTF 2.0 that the importer reads, as data for `ConformToGltfSchema`.
namespace shutterline::engine {

enum class GltfKind : uint8_t {
  kIndex,       ///< Into the document's array `target`, a path of names: "nodes", "extensions/x/lights".
  kIndexList,   ///< An array of such.
  kIndexMap,    ///< An object whose values are such (attributes).
  kIndexMaps,   ///< An array of such objects (morph targets).
  kSize,        ///< 0 to 2^53: bytes and counts.
  kInt,         ///< 0 to 2^31 - 1, among `codes` where there are any.
  kNumber,      ///< Fits a float.
  kNumberList,  ///< `length` of them where it is not 0.
  kBool,
  kString,
  kWord,  ///< A string among `words`.
  kStringList,
  kObject,      ///< Of `shape`.
  kObjectList,  ///< An array of such.
  kPresence,    ///< An object of which only the presence counts.
};

struct GltfField;
using GltfShape = std::vector<GltfField>;

struct GltfField {
  const char* name;
  GltfKind kind;
  bool required = false;
  const char* target = nullptr;
  size_t length = 0;
  std::vector<int> codes = {};
  std::vector<absl::string_view> words = {};
  const GltfShape* shape = nullptr;
};

/// The shape of the root object. Built once, lives for ever.
const GltfShape& GltfRootShape();

}  // namespace shutterline::engine
