#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "worker/engine/scene/asset_source.h"
#include "worker/engine/scene/gltf_budget.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/gltf_tiny.h"

namespace shutterline::engine {

/// Where an image's encoded bytes are: in a buffer view, or under a URI as the file has it.
struct GltfImageSource {
  std::string name;
  std::string uri;
  int buffer_view = -1;
};

/// A glTF file in the middle of its import: a model whose every property has passed the schema, whose
/// buffer views lie within their buffers and whose accessors lie within their views.
struct GltfDocument {
  GltfDocument(const AssetSource& asset_source, const ImportLimits& import_limits);
  GltfDocument(const GltfDocument&) = delete;  // `buffers` point into `storage`.

  const AssetSource& source;
  const ImportLimits limits;
  tinygltf::Model model;
  std::vector<GltfImageSource> images;
  std::vector<PunctualLight> lights;
  std::vector<absl::string_view> buffers;  ///< As long as their byteLength says.

  GltfBudget file_bytes, memory, vertices, triangles, texture_pixels, drawn_triangles, drawn_vertices, posed;
  ImportReport report;

  /// For people; past a thousand they are only counted.
  void Warn(std::string warning);
  /// Adds the line that counts the warnings left out. Called once, at the end.
  void CloseWarnings();

  absl::string_view ViewBytes(int buffer_view) const;

  std::vector<std::string> storage;  ///< What `buffers` point into.

 private:
  uint64_t unlisted_warnings_ = 0;
};

/// "mesh 3 (wheel)", or "mesh 3" where it has no name.
std::string GltfElement(absl::string_view kind, size_t index, absl::string_view name);

/// Reads the root file and all buffers into `document`.
absl::Status LoadGltfDocument(GltfDocument* document);

/// The JSON of the root file, whose bytes are `root`, checked by the schema; `bin`, the GLB's binary chunk,
/// points into them.
absl::Status ParseGltfRoot(GltfDocument* document, absl::string_view root, nlohmann::json* json,
                           absl::string_view* bin, bool* has_bin);

/// The same of a root file that is still to be read; `root` keeps its bytes.
absl::Status ReadGltfRoot(GltfDocument* document, nlohmann::json* json, std::string* root,
                          absl::string_view* bin, bool* has_bin);

}  // namespace shutterline::engine
