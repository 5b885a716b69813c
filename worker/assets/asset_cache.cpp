#include "worker/assets/asset_cache.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/log.h"
#include "common/base/status_macros.h"

namespace shutterline::worker {
namespace {

namespace fs = std::filesystem;

/// Temporary files older than this were left by a process that died.
constexpr std::chrono::hours kStaleTemporary{1};

absl::Status ErrnoStatus(int error, absl::string_view doing, const fs::path& path) {
  return absl::ErrnoToStatus(error, absl::StrCat(doing, " ", path.string()));
}

/// A file descriptor that closes itself.
class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int get() const { return descriptor_; }

 private:
  const int descriptor_;
};

absl::Status WriteAll(int descriptor, absl::string_view bytes, const fs::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return ErrnoStatus(errno, "write", path);
    bytes.remove_prefix(size_t(written));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<AssetCache>> AssetCache::Open(AssetCacheOptions options) {
  std::error_code error;
  fs::create_directories(options.folder / "tmp", error);
  if (error) {
    return ErrnoStatus(error.value(), "open asset cache: create folder", options.folder / "tmp");
  }
  std::unique_ptr<AssetCache> cache(new AssetCache(std::move(options)));
  SL_RETURN_IF_ERROR(Annotate(cache->Scan(), "open asset cache"));
  return cache;
}

absl::Status AssetCache::Scan() {
  struct Found {
    fs::file_time_type used;
    Digest digest;
    uint64_t bytes;
  };
  std::vector<Found> found;
  std::error_code error;
  fs::recursive_directory_iterator it(options_.folder, error);
  if (error) return ErrnoStatus(error.value(), "list", options_.folder);
  const auto now = fs::file_time_type::clock::now();
  for (; it != fs::recursive_directory_iterator(); it.increment(error)) {
    if (error) return ErrnoStatus(error.value(), "list", options_.folder);
    // Another worker may delete a file under our eyes: what cannot be looked at is skipped.
    std::error_code gone;
    if (!it->is_regular_file(gone) || gone) continue;
    const auto used = it->last_write_time(gone);
    const uint64_t bytes = gone ? 0 : it->file_size(gone);
    if (gone) continue;
    if (it->path().parent_path() == options_.folder / "tmp") {
      if (now - used > kStaleTemporary) fs::remove(it->path(), gone);
      continue;
    }
    const auto digest = Digest::FromHex(it->path().filename().string());
    if (!digest.ok() || PathOf(*digest) != it->path()) continue;  // Not ours: left alone.
    found.push_back({used, *digest, bytes});
  }
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.used < b.used; });
  for (const Found& blob : found) Touch(blob.digest, blob.bytes);
  return absl::OkStatus();
}

std::unique_ptr<AssetCache::Pin> AssetCache::MakePin(const Digest& digest) {
  absl::MutexLock lock(&mutex_);
  ++pins_[digest];
  return std::make_unique<Pin>(this, digest);
}

void AssetCache::Unpin(const Digest& digest) {
  absl::MutexLock lock(&mutex_);
  const auto pin = pins_.find(digest);
  if (--pin->second == 0) pins_.erase(pin);
  EvictLocked();
}

absl::StatusOr<std::string> AssetCache::Get(const Digest& digest, uint64_t max_bytes, BlobFetcher& fetcher) {
  absl::StatusOr<std::string> stored = ReadFile(digest, max_bytes);
  if (stored.ok() || !absl::IsNotFound(stored.status())) return stored;

  absl::StatusOr<std::string> fetched = fetcher.Fetch(digest, max_bytes);
  if (!fetched.ok()) return Annotate(fetched.status(), absl::StrCat("fetch blob ", digest.ToHex()));
  if (fetched->size() > max_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat("fetch blob ", digest.ToHex(), ": has ", fetched->size(),
                                                     " bytes, more than the limit of ", max_bytes));
  }
  if (const Digest actual = Sha256(*fetched); actual != digest) {
    return absl::DataLossError(absl::StrCat("fetch blob ", digest.ToHex(), ": the ", fetched->size(),
                                            " bytes received have digest ", actual.ToHex()));
  }
  if (const absl::Status written = WriteFile(digest, *fetched); !written.ok()) {
    spdlog::warn("blob not cached digest={} reason={}", digest.ToHex(), LogValue(written.ToString()));
  }
  return fetched;
}

uint64_t AssetCache::stored_bytes() const {
  absl::MutexLock lock(&mutex_);
  return stored_bytes_;
}

bool AssetCache::Contains(const Digest& digest) const {
  absl::MutexLock lock(&mutex_);
  return entries_.contains(digest);
}

fs::path AssetCache::PathOf(const Digest& digest) const {
  const std::string hex = digest.ToHex();
  return options_.folder / hex.substr(0, 2) / hex;
}

absl::StatusOr<std::string> AssetCache::ReadFile(const Digest& digest, uint64_t max_bytes) {
  const fs::path path = PathOf(digest);
  const File file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat info {};
  if (file.get() < 0 || fstat(file.get(), &info) != 0) {
    // Whatever keeps us from the file (another worker evicted it, say), it can be fetched.
    Forget(digest);
    return absl::NotFoundError(path.string());
  }
  if (uint64_t(info.st_size) > max_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat("blob ", digest.ToHex(), " has ", info.st_size,
                                                     " bytes, more than the limit of ", max_bytes));
  }
  std::string bytes(size_t(info.st_size), '\0');
  size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t count = read(file.get(), bytes.data() + filled, bytes.size() - filled);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    filled += size_t(count);
  }
  if (filled < bytes.size() || Sha256(bytes) != digest) {
    spdlog::warn("cached blob is corrupt and fetched again digest={} path={}", digest.ToHex(),
                 LogValue(path.string()));
    unlink(path.c_str());
    Forget(digest);
    return absl::NotFoundError(path.string());
  }
  futimens(file.get(), nullptr);  // Used now; only the order of eviction depends on it.
  Touch(digest, bytes.size());
  return bytes;
}

absl::Status AssetCache::WriteFile(const Digest& digest, const std::string& bytes) {
  uint64_t number = 0;
  {
    absl::MutexLock lock(&mutex_);
    number = next_temporary_++;
  }
  const fs::path path = PathOf(digest);
  std::error_code error;
  fs::create_directory(path.parent_path(), error);
  if (error) return ErrnoStatus(error.value(), "create folder", path.parent_path());
  // The address tells apart two caches of one process, the pid those of two processes. A clash between
  // machines that share a folder fails on O_EXCL and costs only the caching.
  const fs::path temporary =
      options_.folder / "tmp" /
      absl::StrCat(getpid(), "-", absl::Hex(reinterpret_cast<uintptr_t>(this)), "-", number);
  // No fsync: a torn file is found by its digest.
  {
    const File file(open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
    if (file.get() < 0) return ErrnoStatus(errno, "create", temporary);
    if (absl::Status written = WriteAll(file.get(), bytes, temporary); !written.ok()) {
      unlink(temporary.c_str());
      return written;
    }
  }
  if (rename(temporary.c_str(), path.c_str()) != 0) {
    const absl::Status failed = ErrnoStatus(errno, "rename to", path);
    unlink(temporary.c_str());
    return failed;
  }
  Touch(digest, bytes.size());
  return absl::OkStatus();
}

void AssetCache::Touch(const Digest& digest, uint64_t bytes) {
  absl::MutexLock lock(&mutex_);
  const auto [position, inserted] = entries_.try_emplace(digest);
  Entry& entry = position->second;
  if (inserted) {
    order_.push_front(digest);
    entry.order = order_.begin();
  } else {
    order_.splice(order_.begin(), order_, entry.order);
    stored_bytes_ -= entry.bytes;
  }
  entry.bytes = bytes;
  stored_bytes_ += bytes;
  EvictLocked();
}

void AssetCache::Forget(const Digest& digest) {
  absl::MutexLock lock(&mutex_);
  const auto entry = entries_.find(digest);
  if (entry == entries_.end()) return;
  stored_bytes_ -= entry->second.bytes;
  order_.erase(entry->second.order);
  entries_.erase(entry);
}

void AssetCache::EvictLocked() {
  auto candidate = order_.end();
  while (stored_bytes_ > options_.max_bytes && candidate != order_.begin()) {
    --candidate;
    if (pins_.contains(*candidate)) continue;
    const auto entry = entries_.find(*candidate);
    unlink(PathOf(*candidate).c_str());
    stored_bytes_ -= entry->second.bytes;
    entries_.erase(entry);
    candidate = order_.erase(candidate);
  }
}

}  // namespace shutterline::worker
