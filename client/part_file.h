#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <memory>
#include <string>

#include "common/asset/digest.h"

namespace shutterline::client {

/// A file that arrives in pieces and appears whole or not at all: Append* Commit. The pieces collect in a
/// hidden file beside the target, which stays when an object is dropped without Commit or Discard, so that
/// a later one goes on where it ended. Not thread-safe; other processes are kept out by a lock.
class PartFile {
 public:
  /// Opens or makes the part of `target`; `tag`, of letters, digits and dashes, keeps the parts of
  /// different contents apart. NOT_FOUND where the target's folder does not exist, UNAVAILABLE where another
  /// process is writing the same part.
  static absl::StatusOr<std::unique_ptr<PartFile>> Open(const std::string& target, absl::string_view tag);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  /// Bytes that are here, from the beginning.
  uint64_t size() const { return size_; }
  absl::Status Append(absl::string_view bytes);
  /// Back to nothing.
  absl::Status Restart();
  /// DATA_LOSS, leaving the target as it was, unless the bytes have this digest. Otherwise flushes them to
  /// the disk and renames them to the target, replacing what was there.
  absl::Status Commit(const Digest& digest);
  /// Removes the part.
  void Discard();
  /// Removes what an earlier object left of this part, if anything.
  static void Remove(const std::string& target, absl::string_view tag);

 private:
  PartFile(std::string target, std::string part, int file);
  absl::Status Adopt();

  const std::string target_, part_;
  int file_;
  uint64_t size_ = 0;
  std::unique_ptr<Sha256Stream> hash_;
};

/// The tag of a job's frame.
std::string FramePartTag(absl::string_view job_id, int frame);

}  // namespace shutterline::client
