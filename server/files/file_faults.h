#pragma once

#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>

namespace shutterline::server {

/// An operation that changes what a disk holds, just before the kernel is asked for it.
struct FileOperation {
  enum class Kind { kCreate, kWrite, kTruncate, kSync, kSyncFolder, kRename, kRemove, kMakeFolder };
  Kind kind = Kind::kWrite;
  absl::string_view path;
  size_t bytes = 0;  ///< Of kWrite.
};

/// Decides what becomes of file operations: for tests, which let disks fill up and processes die at any of
/// them. Called by every thread that uses files.
class FileFaults {
 public:
  struct Verdict {
    int error = 0;            ///< An errno with which the operation fails, undone; 0: it goes on.
    size_t bytes = SIZE_MAX;  ///< Of kWrite: the kernel is given no more than these at once. At least 1.
  };
  virtual ~FileFaults() = default;
  virtual Verdict Before(const FileOperation& operation) = 0;
};

/// From now on `faults` is asked, which outlives that; null: nobody, as in every program.
void InstallFileFaults(FileFaults* faults);

/// What the installed faults say; to go on where there are none.
FileFaults::Verdict AskFileFaults(const FileOperation& operation);

}  // namespace shutterline::server
