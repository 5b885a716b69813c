#include "common/base/atomic_file.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>

namespace shutterline {
namespace {

absl::Status Failure(int error, absl::string_view action, absl::string_view path) {
  return absl::ErrnoToStatus(error, absl::StrCat("write ", path, ": ", action));
}

std::string FolderOf(const std::string& path) {
  const size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

/// Returns 0 or an errno.
int WriteAll(int file, absl::string_view contents) {
  while (!contents.empty()) {
    const ssize_t written = write(file, contents.data(), contents.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    contents.remove_prefix(size_t(written));
  }
  return 0;
}

/// Flushes a folder's entries. File systems that cannot (EINVAL) have nothing to flush.
int FlushFolder(const std::string& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  const int error = fsync(descriptor) != 0 && errno != EINVAL ? errno : 0;
  close(descriptor);
  return error;
}

}  // namespace

absl::Status WriteFileAtomically(const std::string& path, absl::string_view contents) {
  const std::string folder = FolderOf(path);
  static std::atomic<uint64_t> counter{0};

  // Create a file that nobody else has, next to the target: rename does not cross file systems.
  std::string temporary;
  int file = -1;
  do {
    temporary = absl::StrCat(folder, "/.shutterline-", getpid(), "-", counter++, ".part");
    file = open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (file < 0 && (errno == EEXIST || errno == EINTR));
  if (file < 0) return Failure(errno, absl::StrCat("cannot create a file in ", folder), path);

  absl::string_view action = "cannot write";
  int error = WriteAll(file, contents);
  if (error == 0 && fsync(file) != 0) {
    action = "cannot flush";
    error = errno;
  }
  if (close(file) != 0 && error == 0) {
    action = "cannot close";
    error = errno;
  }
  if (error == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) {
    action = "cannot rename the temporary file";
    error = errno;
  }
  if (error != 0) {
    unlink(temporary.c_str());
    return Failure(error, action, path);
  }
  error = FlushFolder(folder);
  return error == 0 ? absl::OkStatus() : Failure(error, absl::StrCat("cannot flush folder ", folder), path);
}

}  // namespace shutterline
