#include "worker/engine/scene/directory_asset_source.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <filesystem>
#include <fstream>
#include <system_error>

#include "common/base/status_macros.h"
#include "worker/engine/scene/gltf_uri.h"

namespace shutterline::engine {
namespace {

/// A named pipe or a device would block or never end, so only regular files are opened.
absl::Status CheckRegularFile(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    return absl::NotFoundError(absl::StrCat("file ", path.string(), " is not there"));
  }
  if (!std::filesystem::is_regular_file(status)) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), " is not a regular file"));
  }
  return absl::OkStatus();
}

}  // namespace

DirectoryAssetSource::DirectoryAssetSource(std::string folder, std::string root_name)
    : folder_(std::move(folder)), root_name_(std::move(root_name)) {}

absl::StatusOr<std::unique_ptr<DirectoryAssetSource>> DirectoryAssetSource::Open(
    const std::string& root_path) {
  const std::filesystem::path path(root_path);
  SL_RETURN_IF_ERROR(CheckRegularFile(path));
  return std::unique_ptr<DirectoryAssetSource>(
      new DirectoryAssetSource(path.parent_path().string(), path.filename().string()));
}

absl::StatusOr<std::string> DirectoryAssetSource::Read(absl::string_view relative_uri,
                                                       uint64_t max_bytes) const {
  std::string name = root_name_;  // Taken as it is: the user may call a file what they like.
  if (relative_uri != root_name_) {
    SL_ASSIGN_OR_RETURN(name, NormalizeRelativePath(relative_uri));
  }
  const std::filesystem::path path = std::filesystem::path(folder_) / name;
  SL_RETURN_IF_ERROR(CheckRegularFile(path));
  std::error_code error;
  const uint64_t size = std::filesystem::file_size(path, error);
  if (error) return absl::UnavailableError(absl::StrCat("read ", path.string(), ": ", error.message()));
  if (size > max_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("file ", path.string(), " has ", size, " bytes, more than the limit of ", max_bytes));
  }
  std::string bytes(size, '\0');
  std::ifstream stream(path, std::ios::binary);
  if (!stream.read(bytes.data(), std::streamsize(size)) && size > 0) {
    return absl::UnavailableError(absl::StrCat("read ", path.string(), ": it cannot be read to its end"));
  }
  return bytes;
}

}  // namespace shutterline::engine
