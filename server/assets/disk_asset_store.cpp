#include "server/assets/disk_asset_store.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <map>
#include <optional>
#include <utility>

#include "common/base/log.h"
#include "common/base/retry_hint.h"
#include "common/base/status_macros.h"
#include "server/files/file.h"

namespace shutterline::server {
namespace {

constexpr size_t kHashPiece = size_t{1} << 20;

absl::StatusOr<Digest> DigestOf(const File& file, uint64_t size) {
  Sha256Stream stream;
  for (uint64_t offset = 0; offset < size; offset += kHashPiece) {
    SL_ASSIGN_OR_RETURN(const std::string piece, file.ReadAt(offset, kHashPiece));
    stream.Update(piece);
  }
  return stream.Finish();
}

}  // namespace

class DiskAssetStore::Writer final : public BlobWriter {
 public:
  Writer(DiskAssetStore& store, const Digest& digest, uint64_t size)
      : store_(store), digest_(digest), size_(size) {}
  ~Writer() override { store_.Release(digest_, complete_ ? size_ : written_); }

  absl::Status Open(uint64_t offset) {
    const std::string path = store_.IncomingPath(digest_);
    SL_ASSIGN_OR_RETURN(file_, File::OpenToWrite(path));
    SL_ASSIGN_OR_RETURN(written_, file_->Size());
    if (written_ > size_) {  // Another size was announced before; one of the two was wrong.
      SL_RETURN_IF_ERROR(file_->Truncate(0));
      written_ = 0;
    }
    if (written_ == 0) hash_.emplace();
    if (offset == written_) return absl::OkStatus();
    return absl::OutOfRangeError(absl::StrCat("blob ", digest_.ToHex(), ": the write starts at ", offset,
                                              ", but ", written_, " bytes are here"));
  }

  absl::Status Append(absl::string_view data) override {
    if (data.size() > size_ - written_) {
      return absl::InvalidArgumentError(
          absl::StrCat("blob ", digest_.ToHex(), ": more than the announced ", size_, " bytes came"));
    }
    SL_RETURN_IF_ERROR(file_->WriteAt(written_, data));
    if (hash_) hash_->Update(data);
    written_ += data.size();
    return absl::OkStatus();
  }

  absl::StatusOr<CommittedBlob> Finish() override {
    if (written_ < size_) return CommittedBlob{written_, false};
    SL_ASSIGN_OR_RETURN(const Digest actual, FinishHash());
    if (actual != digest_) {
      SL_RETURN_IF_ERROR(RemoveFile(file_->path()));
      written_ = 0;
      return absl::InvalidArgumentError(absl::StrCat("blob ", digest_.ToHex(), ": the ", size_,
                                                     " bytes that came have the digest ", actual.ToHex()));
    }
    const Durability durability = store_.options_.durability;
    SL_RETURN_IF_ERROR(file_->SyncData(durability));
    const std::string path = store_.BlobPath(digest_);
    SL_RETURN_IF_ERROR(MakeFolders(path.substr(0, path.rfind('/')), durability));
    SL_RETURN_IF_ERROR(RenameDurably(file_->path(), path, durability));
    complete_ = true;
    return CommittedBlob{size_, true};
  }

 private:
  absl::StatusOr<Digest> FinishHash() {
    if (!hash_) return DigestOf(*file_, size_);
    const Digest digest = hash_->Finish();
    hash_.reset();
    return digest;
  }

  DiskAssetStore& store_;
  const Digest digest_;
  const uint64_t size_;
  std::optional<File> file_;
  uint64_t written_ = 0;
  /// Of what came; empty where an earlier writer began. What that one left is read back once, at the end: who
  /// breaks off and begins again must not cost a reading each time.
  std::optional<Sha256Stream> hash_;
  bool complete_ = false;
};

class DiskAssetStore::Pins final : public BlobPins {
 public:
  Pins(DiskAssetStore& store, std::vector<Digest> digests) : store_(store), digests_(std::move(digests)) {
    absl::MutexLock lock(&store_.mutex_);
    for (const Digest& digest : digests_) store_.ledger_.Pin(digest);
  }
  ~Pins() override {
    absl::MutexLock lock(&store_.mutex_);
    for (const Digest& digest : digests_) store_.ledger_.Unpin(digest);
  }

 private:
  DiskAssetStore& store_;
  const std::vector<Digest> digests_;
};

absl::StatusOr<std::unique_ptr<DiskAssetStore>> DiskAssetStore::Open(const std::string& folder,
                                                                     const Options& options,
                                                                     const Clock& clock) {
  SL_RETURN_IF_ERROR(MakeFolders(absl::StrCat(folder, "/blobs"), options.durability));
  SL_RETURN_IF_ERROR(MakeFolders(absl::StrCat(folder, "/incoming"), options.durability));
  std::unique_ptr<DiskAssetStore> store(new DiskAssetStore(folder, options, clock));
  SL_RETURN_IF_ERROR(store->ReadFolder());
  return store;
}

absl::Status DiskAssetStore::ReadFolder() {
  std::multimap<int64_t, std::pair<Digest, uint64_t>> by_use;
  const auto note = [&](const std::string& path, const std::string& name) {
    const absl::StatusOr<Digest> digest = Digest::FromHex(name);
    struct stat info {};
    if (!digest.ok() || ::stat(path.c_str(), &info) != 0) return;  // None of ours.
    by_use.emplace(int64_t(info.st_mtim.tv_sec) * 1'000'000'000 + info.st_mtim.tv_nsec,
                   std::make_pair(*digest, uint64_t(info.st_size)));
  };
  const std::string incoming = absl::StrCat(folder_, "/incoming"), blobs = absl::StrCat(folder_, "/blobs");
  SL_ASSIGN_OR_RETURN(const std::vector<std::string> unfinished, ListFolder(incoming));
  for (const std::string& name : unfinished) note(absl::StrCat(incoming, "/", name), name);
  SL_ASSIGN_OR_RETURN(const std::vector<std::string> shelves, ListFolder(blobs));
  for (const std::string& shelf : shelves) {
    const std::string path = absl::StrCat(blobs, "/", shelf);
    SL_ASSIGN_OR_RETURN(const std::vector<std::string> names, ListFolder(path));
    for (const std::string& name : names) note(absl::StrCat(path, "/", name), name);
  }
  absl::MutexLock lock(&mutex_);
  for (const auto& [time, blob] : by_use) ledger_.Set(blob.first, blob.second, -absl::InfiniteDuration());
  return absl::OkStatus();
}

std::shared_ptr<const BlobPins> DiskAssetStore::Pin(std::vector<Digest> digests) {
  return std::make_shared<Pins>(*this, std::move(digests));
}

uint64_t DiskAssetStore::bytes() const {
  absl::MutexLock lock(&mutex_);
  return ledger_.bytes();
}

absl::Status DiskAssetStore::Reserve(const Digest& digest, uint64_t size) {
  const absl::Duration now = clock_.Monotonic();
  // What is here of it already is a part of `size`, and must not be evicted to make room for the rest.
  ledger_.Set(digest, size, now);
  if (options_.limit_bytes == 0) return absl::OkStatus();
  const std::optional<std::vector<Digest>> victims = ledger_.Victims(options_.limit_bytes, now);
  if (!victims) {
    return WithRetryHint(
        absl::ResourceExhaustedError(absl::StrCat(
            "blob ", digest.ToHex(), ": with its ", size,
            " bytes, blobs that are needed or were used within ", absl::FormatDuration(options_.grace),
            " would take more than the ", options_.limit_bytes, " bytes that all may take")),
        absl::Seconds(10));
  }
  for (const Digest& victim : *victims) SL_RETURN_IF_ERROR(Evict(victim));
  return absl::OkStatus();
}

absl::Status DiskAssetStore::Evict(const Digest& digest) {
  if (being_written_.contains(digest)) return absl::OkStatus();  // Used this moment: it is not counted old.
  SL_RETURN_IF_ERROR(RemoveFile(BlobPath(digest)));
  SL_RETURN_IF_ERROR(RemoveFile(IncomingPath(digest)));
  ledger_.Remove(digest);
  spdlog::info("blob evicted digest={} bytes_left={}", digest.ToHex(), ledger_.bytes());
  return absl::OkStatus();
}

std::string DiskAssetStore::BlobPath(const Digest& digest) const {
  const std::string hex = digest.ToHex();
  return absl::StrCat(folder_, "/blobs/", hex.substr(0, 2), "/", hex);
}

std::string DiskAssetStore::IncomingPath(const Digest& digest) const {
  return absl::StrCat(folder_, "/incoming/", digest.ToHex());
}

void DiskAssetStore::Release(const Digest& digest, uint64_t bytes_left) {
  absl::MutexLock lock(&mutex_);
  being_written_.erase(digest);
  if (bytes_left == 0) {
    ledger_.Remove(digest);
  } else {
    ledger_.Set(digest, bytes_left, clock_.Monotonic());
  }
}

absl::StatusOr<CommittedBlob> DiskAssetStore::Query(const Digest& digest) {
  const absl::StatusOr<uint64_t> size = Size(digest);
  if (size.ok()) return CommittedBlob{*size, true};
  if (!absl::IsNotFound(size.status())) return size.status();
  const absl::StatusOr<File> incoming = File::OpenToRead(IncomingPath(digest));
  if (absl::IsNotFound(incoming.status())) return CommittedBlob{};
  SL_RETURN_IF_ERROR(incoming.status());
  SL_ASSIGN_OR_RETURN(const uint64_t written, incoming->Size());
  return CommittedBlob{written, false};
}

absl::StatusOr<std::unique_ptr<BlobWriter>> DiskAssetStore::Write(const Digest& digest, uint64_t size,
                                                                  uint64_t offset) {
  if (size > options_.max_blob_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat("blob ", digest.ToHex(), ": has ", size,
                                                     " bytes, but at most ", options_.max_blob_bytes,
                                                     " are taken"));
  }
  {
    absl::MutexLock lock(&mutex_);
    if (!being_written_.insert(digest).second) {
      return absl::AbortedError(absl::StrCat("blob ", digest.ToHex(), ": another writer is at it"));
    }
    if (const absl::Status reserved = Reserve(digest, size); !reserved.ok()) {
      being_written_.erase(digest);
      ledger_.Remove(digest);
      return reserved;
    }
  }
  auto writer = std::make_unique<Writer>(*this, digest, size);  // Releases the digest when it ends.
  SL_RETURN_IF_ERROR(writer->Open(offset));
  return std::unique_ptr<BlobWriter>(std::move(writer));
}

absl::StatusOr<uint64_t> DiskAssetStore::Size(const Digest& digest) {
  const std::string path = BlobPath(digest);
  // Under the mutex, so that it is not evicted between the look and the use that this is.
  absl::MutexLock lock(&mutex_);
  const absl::StatusOr<File> file = File::OpenToRead(path);
  if (absl::IsNotFound(file.status())) {
    return absl::NotFoundError(absl::StrCat("blob ", digest.ToHex(), " is not here"));
  }
  SL_RETURN_IF_ERROR(file.status());
  ledger_.Touch(digest, clock_.Monotonic());
  // The time of last use is for the order of eviction alone: where it cannot be set, nothing is lost.
  if (options_.limit_bytes > 0) (void)::utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
  return file->Size();
}

absl::StatusOr<std::string> DiskAssetStore::Read(const Digest& digest, uint64_t offset, size_t count) {
  const absl::StatusOr<File> file = File::OpenToRead(BlobPath(digest));
  if (absl::IsNotFound(file.status())) {
    return absl::NotFoundError(absl::StrCat("blob ", digest.ToHex(), " is not here"));
  }
  SL_RETURN_IF_ERROR(file.status());
  return file->ReadAt(offset, count);
}

absl::StatusOr<std::string> DiskAssetStore::ReadVerified(const Digest& digest, uint64_t max_bytes) {
  SL_ASSIGN_OR_RETURN(const uint64_t size, Size(digest));
  if (size > max_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat("blob ", digest.ToHex(), ": has ", size,
                                                     " bytes, but only ", max_bytes, " may be read"));
  }
  SL_ASSIGN_OR_RETURN(std::string data, Read(digest, 0, size_t(size)));
  if (Sha256(data) == digest) return data;
  ReportDamage(digest);
  return absl::DataLossError(
      absl::StrCat("blob ", digest.ToHex(), ": the disk holds other bytes; upload it again"));
}

void DiskAssetStore::ReportDamage(const Digest& digest) {
  spdlog::error("stored blob is damaged and removed digest={}", digest.ToHex());
  absl::MutexLock lock(&mutex_);
  ledger_.Remove(digest);
  const absl::Status status = RemoveFile(BlobPath(digest));
  if (!status.ok())
    spdlog::error("damaged blob cannot be removed digest={} reason={}", digest.ToHex(),
                  LogValue(status.message()));
}

}  // namespace shutterline::server
