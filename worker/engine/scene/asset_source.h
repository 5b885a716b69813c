#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <string>

namespace shutterline::engine {

/// Where a scene's files come from: a folder, or blobs named by a manifest. The importer reads files
/// through this alone, so a hostile URI reaches nothing that the source does not offer.
class AssetSource {
 public:
  virtual ~AssetSource() = default;

  /// The root file's name, relative to the source ("fox.gltf").
  virtual const std::string& RootName() const = 0;

  /// The bytes of the root file or of a file beside it, by its decoded relative URI. NOT_FOUND where
  /// there is none, RESOURCE_EXHAUSTED where it is larger than `max_bytes`, INVALID_ARGUMENT where the
  /// URI is absolute or leaves the root's folder.
  virtual absl::StatusOr<std::string> Read(absl::string_view relative_uri, uint64_t max_bytes) const = 0;
};

}  // namespace shutterline::engine
