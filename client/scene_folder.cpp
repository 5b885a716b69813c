#include "client/scene_folder.h"

#include <absl/cleanup/cleanup.h>
#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>
#include <vector>

#include "common/asset/digest.h"
#include "common/base/status_macros.h"
#include "worker/engine/scene/gltf_import.h"

namespace shutterline::client {

SceneFolder::SceneFolder(absl::string_view scene_path) {
  const size_t slash = scene_path.rfind('/');
  const size_t name = slash == absl::string_view::npos ? 0 : slash + 1;
  folder_ = std::string(scene_path.substr(0, name));
  root_name_ = std::string(scene_path.substr(name));
}

absl::StatusOr<std::string> SceneFolder::Read(absl::string_view relative_uri, uint64_t max_bytes) const {
  SL_RETURN_IF_ERROR(Annotate(ValidateRelativeName(relative_uri), "file name"));
  const std::string path = absl::StrCat(folder_, relative_uri);
  // Without O_NONBLOCK, opening a pipe that nobody writes to would wait for ever.
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return absl::ErrnoToStatus(errno, absl::StrCat("read ", path));
  const absl::Cleanup closer = [file] { close(file); };

  struct stat facts {};
  if (fstat(file, &facts) != 0) return absl::ErrnoToStatus(errno, absl::StrCat("read ", path));
  if (!S_ISREG(facts.st_mode)) {
    return absl::InvalidArgumentError(absl::StrCat("read ", path, ": not a regular file"));
  }
  if (static_cast<uint64_t>(facts.st_size) > max_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat("read ", path, ": ", facts.st_size,
                                                     " bytes exceed the limit of ", max_bytes, " bytes"));
  }
  std::string bytes(static_cast<size_t>(facts.st_size), '\0');
  size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t got = read(file, &bytes[have], bytes.size() - have);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return absl::ErrnoToStatus(errno, absl::StrCat("read ", path));
    if (got == 0) return absl::AbortedError(absl::StrCat("read ", path, ": the file shrank meanwhile"));
    have += static_cast<size_t>(got);
  }
  return bytes;
}

absl::StatusOr<SceneManifest> BuildManifest(const SceneFolder& folder, uint64_t max_file_bytes) {
  SceneManifest manifest;
  manifest.root_name = folder.RootName();
  engine::ImportLimits limits;
  limits.max_file_bytes = std::min(limits.max_file_bytes, max_file_bytes);
  std::vector<std::string> names{folder.RootName()};
  SL_ASSIGN_OR_RETURN(const std::vector<std::string> external, engine::ListExternalFiles(folder, limits));
  for (const std::string& name : external) {
    if (name != folder.RootName()) names.push_back(name);
  }
  const std::string context = absl::StrCat("load scene ", folder.RootName());
  for (const std::string& name : names) {
    absl::StatusOr<std::string> bytes = folder.Read(name, limits.max_file_bytes);
    if (!bytes.ok()) return Annotate(bytes.status(), context);
    manifest.files.push_back({name, Sha256(*bytes), bytes->size()});
  }
  return manifest;
}

}  // namespace shutterline::client
