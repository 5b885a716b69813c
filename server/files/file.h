#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "server/files/durability.h"

namespace shutterline::server {

/// An open file. Errors have the code of their errno (NOT_FOUND, PERMISSION_DENIED, RESOURCE_EXHAUSTED: disk
/// full, with a retry hint, ...) and name the file. Movable; calls on one object from several threads are as
/// safe as pread and pwrite are.
class File {
 public:
  static absl::StatusOr<File> OpenToRead(const std::string& path);
  /// Reads and writes; made if it is not there.
  static absl::StatusOr<File> OpenToWrite(const std::string& path);
  File(File&& other) noexcept : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}
  File& operator=(File&& other) noexcept;
  ~File();

  const std::string& path() const { return path_; }
  absl::StatusOr<uint64_t> Size() const;
  /// Up to `count` bytes from `offset`; fewer only at the file's end.
  absl::StatusOr<std::string> ReadAt(uint64_t offset, size_t count) const;
  absl::Status WriteAt(uint64_t offset, absl::string_view data);
  absl::Status Truncate(uint64_t size);
  /// Returns once the contents are as durable as is asked.
  absl::Status SyncData(Durability durability);

 private:
  File(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}

  std::string path_;
  int fd_ = -1;
};

/// Makes the folder and those above it; what has been made is as durable as is asked.
absl::Status MakeFolders(const std::string& path, Durability durability);
/// Makes the folder's entries as durable as is asked.
absl::Status SyncFolder(const std::string& path, Durability durability);
/// Renames within one file system, replacing `to`, and makes both folders' entries as durable as is asked.
absl::Status RenameDurably(const std::string& from, const std::string& to, Durability durability);
/// Puts `contents` into `path`, replacing a file that is there: readers see the old one or the new one, never
/// a part. The bytes go to `path`.part first, which is removed on failure; one writer a path at a time.
absl::Status PutFile(const std::string& path, absl::string_view contents, Durability durability);
/// OK also where there is no such file.
absl::Status RemoveFile(const std::string& path);
/// Removes the folder with all that is in it; OK also where there is none.
absl::Status RemoveFolder(const std::string& path);
/// Names in the folder, sorted; none where there is no such folder.
absl::StatusOr<std::vector<std::string>> ListFolder(const std::string& path);

}  // namespace shutterline::server
