#pragma once

#include <sys/types.h>

#include <map>
#include <string>

#include "server/files/file_faults.h"

namespace shutterline::test {

/// What a disk holds for certain of a folder: contents of files as they were at their last flush, names as
/// they were at the last flush of the folder they are in, and nothing else. The worst that a loss of power
/// can leave. SQLite's files, whose flushes cannot be seen, count as flushed.
class ShadowDisk {
 public:
  explicit ShadowDisk(std::string folder) : folder_(std::move(folder)) {}

  /// To be told of every operation before it happens: it is over, and counts, when the next is announced.
  void Before(const server::FileOperation& operation);
  /// Writes what is certain by now into `target`, an empty folder.
  void Restore(const std::string& target) const;

 private:
  void Settle();
  void RestoreFolder(const std::string& path, const std::string& target) const;

  const std::string folder_;
  server::FileOperation::Kind pending_kind_ = server::FileOperation::Kind::kWrite;
  std::string pending_path_;
  std::map<ino_t, std::string> contents_;
  std::map<std::string, std::map<std::string, ino_t>> names_;  ///< By folder.
};

}  // namespace shutterline::test
