#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <string>

namespace shutterline {

/// Puts `contents` into the file `path`, replacing one that is there. Readers see the old file or the new
/// one, never a part: the bytes go to a temporary file in the same folder, which is flushed to the disk
/// and renamed, and then the folder is flushed. On failure the temporary file is removed and `path` is as
/// it was; only where the last flush fails is the new file in place, but not known to survive a power cut.
///
/// Errors have the code of their errno (NOT_FOUND: no such folder; PERMISSION_DENIED;
/// RESOURCE_EXHAUSTED: the disk is full) and name the file. Thread-safe, also for the same path: one of
/// the writers wins. A file that is new has the permissions that the process's umask leaves of 0666.
absl::Status WriteFileAtomically(const std::string& path, absl::string_view contents);

}  // namespace shutterline
