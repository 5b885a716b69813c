#pragma once

#include <memory>
#include <string>

#include "worker/engine/scene/asset_source.h"

namespace shutterline::engine {

/// A scene's root file and the files beside and below it in its folder. URIs that lead out of the folder
/// are refused by their text; symbolic links that the folder's owner has put there are followed. Only
/// regular files are read. Reads the disk at every call; any number of threads may call it.
class DirectoryAssetSource : public AssetSource {
 public:
  /// `root_path`: the scene file. NOT_FOUND or INVALID_ARGUMENT where there is no such regular file.
  static absl::StatusOr<std::unique_ptr<DirectoryAssetSource>> Open(const std::string& root_path);

  const std::string& RootName() const override { return root_name_; }
  absl::StatusOr<std::string> Read(absl::string_view relative_uri, uint64_t max_bytes) const override;

 private:
  DirectoryAssetSource(std::string folder, std::string root_name);

  const std::string folder_;
  const std::string root_name_;
};

}  // namespace shutterline::engine
