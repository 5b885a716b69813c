#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "worker/engine/scene/asset_source.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Upper bounds on what a file may ask for, checked before memory is taken.
struct ImportLimits {
  uint64_t max_file_bytes = uint64_t{2} << 30;      ///< Of each file, and of all buffers together.
  uint64_t max_vertices = uint64_t{1} << 28;        ///< Stored, all meshes.
  uint64_t max_triangles = uint64_t{1} << 28;       ///< Stored, all meshes.
  uint64_t max_texture_pixels = uint64_t{1} << 28;  ///< All images.
  /// Of them, so many for any file, and so many more for each byte of an image: a megabyte of zeros that are
  /// packed well would otherwise unfold into a gigabyte. Images of one colour are honest, but small.
  uint64_t base_texture_pixels = uint64_t{1} << 26;
  uint64_t texture_pixels_per_byte = 64;
  uint32_t max_image_side = 16384;
  uint32_t max_nodes = 1 << 20;
  uint32_t max_depth = 512;                      ///< Of the node tree and of the JSON.
  uint64_t max_json_values = uint64_t{1} << 23;  ///< Each takes some hundred bytes while the file is read.
  /// Triangles and vertices that nodes draw, counted for each node that draws them: so many for any file, and
  /// so many more for each byte of it. A frame stores what is drawn, and a thousand nodes may draw one mesh.
  uint64_t base_drawn = uint64_t{1} << 25;
  double drawn_per_file_byte = 0.25;
  /// Joints and morph weights of what nodes draw, counted for each node that draws it, as a frame poses them
  /// for each at many times: so many for any file, and drawn_per_file_byte more.
  uint64_t base_posed = uint64_t{1} << 18;
  /// Memory that decoded meshes, keys and skins may take: this much for any file, and so many bytes for
  /// each byte of the file. What shares its accessors is stored more than once, so a small file could ask
  /// for far more than its size.
  uint64_t base_memory = uint64_t{512} << 20;
  uint64_t memory_per_file_byte = 64;
  uint64_t max_memory = uint64_t{16} << 30;  ///< Whatever the file's size.
};

/// Imports a glTF 2.0 (.gltf, JSON) or GLB file; what it is, is read from its first bytes.
///
/// Errors are INVALID_ARGUMENT (the file breaks a rule), UNIMPLEMENTED (`extensionsRequired` names one
/// that we do not support), NOT_FOUND (a file), RESOURCE_EXHAUSTED (a limit), DEADLINE_EXCEEDED (the limit of
/// the thread's work). A message names file, element and reason: "load scene fox.glb: accessor 7: byteOffset
/// 120 + 36 × 12 exceeds bufferView 2 (length 400)". A file without anything to draw is an error too.
absl::StatusOr<std::shared_ptr<const Scene>> ImportGltf(const AssetSource& source,
                                                        const ImportLimits& limits = {});

/// The relative URIs, decoded, of the external files that the root file's `buffers` and `images` name,
/// each once, in order. For clients that upload a scene, and so have read the root file, whose bytes are
/// `root`. Errors as above.
absl::StatusOr<std::vector<std::string>> ListExternalFiles(const AssetSource& source, absl::string_view root,
                                                           const ImportLimits& limits = {});

}  // namespace shutterline::engine
