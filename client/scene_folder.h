#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <string>

#include "common/job/job_spec.h"
#include "worker/engine/scene/asset_source.h"

namespace shutterline::client {

/// A scene's files on this machine: the folder that its root file lies in. Thread-safe.
class SceneFolder : public engine::AssetSource {
 public:
  /// `scene_path` names the root file, which is not opened yet.
  explicit SceneFolder(absl::string_view scene_path);

  const std::string& RootName() const override { return root_name_; }
  /// See AssetSource. Besides: INVALID_ARGUMENT for what is not a regular file (a folder, a pipe).
  absl::StatusOr<std::string> Read(absl::string_view relative_uri, uint64_t max_bytes) const override;

 private:
  std::string folder_;     ///< Empty (the working folder) or ending in '/'.
  std::string root_name_;  ///< Relative to folder_.
};

/// Names, sizes and digests of the root file and of every file that it refers to, the root first. Reads
/// each file once. INVALID_ARGUMENT where a name leaves the folder, NOT_FOUND where a file is missing,
/// RESOURCE_EXHAUSTED where one is larger than `max_file_bytes`, and what ListExternalFiles refuses.
absl::StatusOr<SceneManifest> BuildManifest(const SceneFolder& folder, uint64_t max_file_bytes);

}  // namespace shutterline::client
