#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>

#include "client/connection.h"
#include "client/scene_files.h"

namespace shutterline::client {

struct UploadReport {
  int64_t files = 0;           ///< Of the scene.
  uint64_t bytes = 0;          ///< Of the scene.
  int64_t files_uploaded = 0;  ///< Those that the coordinator lacked; equal files count once.
  uint64_t bytes_uploaded = 0;
};

/// Told as an upload advances: bytes sent and to send, of the files that the coordinator lacks.
using UploadProgress = std::function<void(uint64_t sent, uint64_t total)>;

/// Sends those files of `scene` that the coordinator lacks, each from where an earlier attempt broke off, and
/// takes their bytes; no others are kept. A dropped connection is resumed for as long as the connection's
/// retry policy says. Files whose bytes were not kept must not have changed since they were hashed (ABORTED).
absl::StatusOr<UploadReport> Upload(Connection& connection, SceneFiles& scene,
                                    const UploadProgress& progress = nullptr);

/// "3 files, 12.5 MB: all uploaded", "..., unchanged: 0 bytes uploaded": for people.
std::string Describe(const UploadReport& report);

}  // namespace shutterline::client
