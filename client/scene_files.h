#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "common/job/job_spec.h"
#include "worker/engine/scene/asset_source.h"

namespace shutterline::client {

/// A scene's files as they were when they were first read: what a manifest says of them, and their bytes as
/// far as those fit into `max_kept_bytes`, so that most scenes are read and hashed once. Not thread-safe.
class SceneFiles {
 public:
  struct Limits {
    uint64_t max_file_bytes = uint64_t{2} << 30;
    /// Of all files together; what has no room is read again.
    uint64_t max_kept_bytes = uint64_t{256} << 20;
  };

  /// The root file and every file that it refers to, the root first, and the scene's environment, if it has
  /// one, the last. INVALID_ARGUMENT where a URI leaves the root's folder, NOT_FOUND where a file is missing,
  /// RESOURCE_EXHAUSTED where one is larger than may be, and what ListExternalFiles refuses; messages name
  /// the scene, the file and the reason. CANCELLED between two files once `stop`, if there is one, is set.
  static absl::StatusOr<SceneFiles> Read(std::unique_ptr<const engine::AssetSource> source,
                                         const Limits& limits, const std::atomic<bool>* stop = nullptr);

  const SceneManifest& manifest() const { return manifest_; }
  /// The bytes whose digest the manifest has, which are not kept any longer. ABORTED where they were not kept
  /// and the file has changed meanwhile.
  absl::StatusOr<std::string> Take(const SceneFile& file);
  /// Keeps no bytes any longer.
  void DropBytes() { kept_.clear(); }

 private:
  SceneFiles(std::unique_ptr<const engine::AssetSource> source, const Limits& limits)
      : source_(std::move(source)), limits_(limits), room_(limits.max_kept_bytes) {}
  std::string Context() const;
  absl::StatusOr<std::string> ReadFile(const std::string& name, const std::atomic<bool>* stop) const;
  absl::Status ReadEnvironment(const std::atomic<bool>* stop);
  void Add(const std::string& name, std::string bytes);

  std::unique_ptr<const engine::AssetSource> source_;
  const Limits limits_;
  SceneManifest manifest_;
  std::map<std::string, std::string> kept_;  ///< By name.
  uint64_t room_;                            ///< For more to be kept.
};

}  // namespace shutterline::client
