#include "server/files/file.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "common/base/retry_hint.h"
#include "common/base/status_macros.h"
#include "server/files/file_faults.h"

namespace shutterline::server {
namespace {

namespace fs = std::filesystem;

absl::Status StatusOf(int error, absl::string_view doing, const std::string& path) {
  absl::Status status = absl::ErrnoToStatus(error, absl::StrCat(doing, " ", path));
  // Space comes back without our doing.
  return absl::IsResourceExhausted(status) ? WithRetryHint(std::move(status), absl::Seconds(1)) : status;
}

absl::Status Failed(absl::string_view doing, const std::string& path) {
  return StatusOf(errno, doing, path);
}

absl::Status Failed(absl::string_view doing, const std::string& path, const std::error_code& error) {
  return StatusOf(error.value(), doing, path);
}

using Kind = FileOperation::Kind;

/// Asks the installed faults. True: the operation is not to be tried, and errno says how it failed.
bool FailsByFault(Kind kind, absl::string_view path) {
  const int error = AskFileFaults({kind, path, 0}).error;
  if (error != 0) errno = error;
  return error != 0;
}

std::string FolderOf(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

}  // namespace

absl::StatusOr<File> File::OpenToRead(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return Failed("open", path);
  return File(path, fd);
}

absl::StatusOr<File> File::OpenToWrite(const std::string& path) {
  if (FailsByFault(Kind::kCreate, path)) return Failed("open", path);
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (fd < 0) return Failed("open", path);
  return File(path, fd);
}

File& File::operator=(File&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(fd_, other.fd_);
  return *this;
}

File::~File() {
  if (fd_ >= 0) ::close(fd_);
}

absl::StatusOr<uint64_t> File::Size() const {
  struct stat info {};
  if (::fstat(fd_, &info) != 0) return Failed("stat", path_);
  return uint64_t(info.st_size);
}

absl::StatusOr<std::string> File::ReadAt(uint64_t offset, size_t count) const {
  std::string data(count, '\0');
  size_t done = 0;
  while (done < count) {
    const ssize_t got = ::pread(fd_, data.data() + done, count - done, off_t(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Failed("read", path_);
    if (got == 0) break;
    done += size_t(got);
  }
  data.resize(done);
  return data;
}

absl::Status File::WriteAt(uint64_t offset, absl::string_view data) {
  size_t done = 0;
  while (done < data.size()) {
    const FileFaults::Verdict verdict = AskFileFaults({Kind::kWrite, path_, data.size() - done});
    if (verdict.error != 0) {
      errno = verdict.error;
      return Failed("write", path_);
    }
    const size_t count = std::min(data.size() - done, verdict.bytes);
    const ssize_t put = ::pwrite(fd_, data.data() + done, count, off_t(offset + done));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return Failed("write", path_);
    done += size_t(put);
  }
  return absl::OkStatus();
}

absl::Status File::Truncate(uint64_t size) {
  if (FailsByFault(Kind::kTruncate, path_) || ::ftruncate(fd_, off_t(size)) != 0)
    return Failed("truncate", path_);
  return absl::OkStatus();
}

absl::Status File::SyncData(Durability durability) {
  if (durability == Durability::kProcess) return absl::OkStatus();
  if (FailsByFault(Kind::kSync, path_) || ::fdatasync(fd_) != 0) return Failed("flush", path_);
  return absl::OkStatus();
}

absl::Status MakeFolders(const std::string& path, Durability durability) {
  std::error_code error;
  if (fs::is_directory(path, error)) return absl::OkStatus();
  const std::string parent = FolderOf(path);
  if (parent != path) SL_RETURN_IF_ERROR(MakeFolders(parent, durability));
  if (FailsByFault(Kind::kMakeFolder, path)) return Failed("make folder", path);
  if (!fs::create_directory(path, error) && error) return Failed("make folder", path, error);
  return SyncFolder(parent, durability);
}

absl::Status SyncFolder(const std::string& path, Durability durability) {
  if (durability == Durability::kProcess) return absl::OkStatus();
  const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return Failed("open folder", path);
  const bool flushed = !FailsByFault(Kind::kSyncFolder, path) && ::fsync(fd) == 0;
  const absl::Status status = flushed ? absl::OkStatus() : Failed("flush folder", path);
  ::close(fd);
  return status;
}

absl::Status RenameDurably(const std::string& from, const std::string& to, Durability durability) {
  if (FailsByFault(Kind::kRename, to) || ::rename(from.c_str(), to.c_str()) != 0)
    return Failed(absl::StrCat("rename ", from, " to"), to);
  SL_RETURN_IF_ERROR(SyncFolder(FolderOf(to), durability));
  return FolderOf(from) == FolderOf(to) ? absl::OkStatus() : SyncFolder(FolderOf(from), durability);
}

absl::Status PutFile(const std::string& path, absl::string_view contents, Durability durability) {
  const std::string part = absl::StrCat(path, ".part");
  const auto put = [&]() -> absl::Status {
    SL_ASSIGN_OR_RETURN(File file, File::OpenToWrite(part));
    SL_RETURN_IF_ERROR(file.Truncate(0));  // A writer that died may have left one.
    SL_RETURN_IF_ERROR(file.WriteAt(0, contents));
    SL_RETURN_IF_ERROR(file.SyncData(durability));
    return RenameDurably(part, path, durability);
  };
  absl::Status status = put();
  // Where it stays, the next writer replaces it.
  if (!status.ok()) (void)RemoveFile(part);
  return status;
}

absl::Status RemoveFile(const std::string& path) {
  if (FailsByFault(Kind::kRemove, path)) return Failed("remove", path);
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) return Failed("remove", path);
  return absl::OkStatus();
}

absl::Status RemoveFolder(const std::string& path) {
  std::error_code error;
  fs::remove_all(path, error);
  return error ? Failed("remove folder", path, error) : absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> ListFolder(const std::string& path) {
  std::vector<std::string> names;
  std::error_code error;
  if (!fs::exists(path, error)) return names;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error)) {
    names.push_back(entry->path().filename().string());
  }
  if (error) return Failed("list folder", path, error);
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace shutterline::server
