#include "client/part_file.h"

#include <absl/cleanup/cleanup.h>
#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

constexpr size_t kReadBytes = 1 << 20;

/// The folder of a path, with its slash; empty for the working folder.
std::string FolderOf(const std::string& path) {
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

std::string PartOf(const std::string& target, absl::string_view tag) {
  const std::string folder = FolderOf(target);
  return absl::StrCat(folder, ".", target.substr(folder.size()), ".", tag, ".part");
}

absl::Status SyncFolder(const std::string& path) {
  const std::string folder = FolderOf(path);
  const int handle = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return absl::ErrnoToStatus(errno, absl::StrCat("open the folder of ", path));
  const absl::Cleanup closer = [handle] { close(handle); };
  if (fsync(handle) != 0) return absl::ErrnoToStatus(errno, absl::StrCat("flush the folder of ", path));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<PartFile>> PartFile::Open(const std::string& target, absl::string_view tag) {
  const std::string part = PartOf(target, tag);
  while (true) {
    const int file = open(part.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file < 0) return absl::ErrnoToStatus(errno, absl::StrCat("write ", target, ": make ", part));
    std::unique_ptr<PartFile> result(new PartFile(target, part, file));
    if (flock(file, LOCK_EX | LOCK_NB) != 0) {
      return absl::UnavailableError(absl::StrCat("write ", target, ": another process is writing ", part));
    }
    // Whoever held the lock before may have renamed or removed what we opened.
    struct stat ours {
    }, named{};
    if (fstat(file, &ours) != 0 || stat(part.c_str(), &named) != 0 || ours.st_ino != named.st_ino ||
        ours.st_dev != named.st_dev) {
      continue;
    }
    SL_RETURN_IF_ERROR(result->Adopt());
    return result;
  }
}

PartFile::PartFile(std::string target, std::string part, int file)
    : target_(std::move(target)),
      part_(std::move(part)),
      file_(file),
      hash_(std::make_unique<Sha256Stream>()) {}

PartFile::~PartFile() {
  if (file_ >= 0) close(file_);
}

absl::Status PartFile::Adopt() {
  std::vector<char> buffer(kReadBytes);
  while (true) {
    const ssize_t got = read(file_, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return absl::ErrnoToStatus(errno, absl::StrCat("read ", part_));
    if (got == 0) return absl::OkStatus();
    hash_->Update(absl::string_view(buffer.data(), static_cast<size_t>(got)));
    size_ += static_cast<uint64_t>(got);
  }
}

absl::Status PartFile::Append(absl::string_view bytes) {
  hash_->Update(bytes);
  while (!bytes.empty()) {
    const ssize_t put = write(file_, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return absl::ErrnoToStatus(errno, absl::StrCat("write ", part_));
    size_ += static_cast<uint64_t>(put);
    bytes.remove_prefix(static_cast<size_t>(put));
  }
  return absl::OkStatus();
}

absl::Status PartFile::Restart() {
  if (ftruncate(file_, 0) != 0 || lseek(file_, 0, SEEK_SET) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("write ", part_));
  }
  size_ = 0;
  hash_ = std::make_unique<Sha256Stream>();
  return absl::OkStatus();
}

absl::Status PartFile::Commit(const Digest& digest) {
  const Digest have = hash_->Finish();
  if (have != digest) {
    return absl::DataLossError(absl::StrCat("write ", target_, ": the ", size_,
                                            " bytes that came have the digest ", have.ToHex(), ", not ",
                                            digest.ToHex()));
  }
  if (fsync(file_) != 0) return absl::ErrnoToStatus(errno, absl::StrCat("write ", part_));
  if (std::rename(part_.c_str(), target_.c_str()) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("write ", target_));
  }
  return SyncFolder(target_);
}

void PartFile::Discard() {
  unlink(part_.c_str());
}

void PartFile::Remove(const std::string& target, absl::string_view tag) {
  unlink(PartOf(target, tag).c_str());
}

std::string FramePartTag(absl::string_view job_id, int frame) {
  return absl::StrCat(job_id, "-", frame);
}

}  // namespace shutterline::client
