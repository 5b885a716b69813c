#include "server/assets/disk_asset_store.h"

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <optional>

#include "common/base/log.h"
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
  ~Writer() override { store_.Release(digest_); }

  absl::Status Open(uint64_t offset) {
    const std::string path = store_.IncomingPath(digest_);
    SL_ASSIGN_OR_RETURN(file_, File::OpenToWrite(path));
    SL_ASSIGN_OR_RETURN(written_, file_->Size());
    if (written_ > size_) {  // Another size was announced before; one of the two was wrong.
      SL_RETURN_IF_ERROR(file_->Truncate(0));
      written_ = 0;
    }
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
    written_ += data.size();
    return absl::OkStatus();
  }

  absl::StatusOr<CommittedBlob> Finish() override {
    if (written_ < size_) return CommittedBlob{written_, false};
    SL_ASSIGN_OR_RETURN(const Digest actual, DigestOf(*file_, size_));
    if (actual != digest_) {
      SL_RETURN_IF_ERROR(RemoveFile(file_->path()));
      return absl::InvalidArgumentError(absl::StrCat("blob ", digest_.ToHex(), ": the ", size_,
                                                     " bytes that came have the digest ", actual.ToHex()));
    }
    SL_RETURN_IF_ERROR(file_->SyncData());
    const std::string path = store_.BlobPath(digest_);
    SL_RETURN_IF_ERROR(MakeFolders(path.substr(0, path.rfind('/'))));
    SL_RETURN_IF_ERROR(RenameDurably(file_->path(), path));
    return CommittedBlob{size_, true};
  }

 private:
  DiskAssetStore& store_;
  const Digest digest_;
  const uint64_t size_;
  std::optional<File> file_;
  uint64_t written_ = 0;
};

absl::StatusOr<std::unique_ptr<DiskAssetStore>> DiskAssetStore::Open(const std::string& folder,
                                                                     uint64_t max_blob_bytes) {
  SL_RETURN_IF_ERROR(MakeFolders(absl::StrCat(folder, "/blobs")));
  SL_RETURN_IF_ERROR(MakeFolders(absl::StrCat(folder, "/incoming")));
  return std::unique_ptr<DiskAssetStore>(new DiskAssetStore(folder, max_blob_bytes));
}

std::string DiskAssetStore::BlobPath(const Digest& digest) const {
  const std::string hex = digest.ToHex();
  return absl::StrCat(folder_, "/blobs/", hex.substr(0, 2), "/", hex);
}

std::string DiskAssetStore::IncomingPath(const Digest& digest) const {
  return absl::StrCat(folder_, "/incoming/", digest.ToHex());
}

void DiskAssetStore::Release(const Digest& digest) {
  absl::MutexLock lock(&mutex_);
  being_written_.erase(digest);
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
  if (size > max_blob_bytes_) {
    return absl::ResourceExhaustedError(absl::StrCat("blob ", digest.ToHex(), ": has ", size,
                                                     " bytes, but at most ", max_blob_bytes_, " are taken"));
  }
  {
    absl::MutexLock lock(&mutex_);
    if (!being_written_.insert(digest).second) {
      return absl::AbortedError(absl::StrCat("blob ", digest.ToHex(), ": another writer is at it"));
    }
  }
  auto writer = std::make_unique<Writer>(*this, digest, size);  // Releases the digest when it ends.
  SL_RETURN_IF_ERROR(writer->Open(offset));
  return std::unique_ptr<BlobWriter>(std::move(writer));
}

absl::StatusOr<uint64_t> DiskAssetStore::Size(const Digest& digest) {
  const absl::StatusOr<File> file = File::OpenToRead(BlobPath(digest));
  if (absl::IsNotFound(file.status())) {
    return absl::NotFoundError(absl::StrCat("blob ", digest.ToHex(), " is not here"));
  }
  SL_RETURN_IF_ERROR(file.status());
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
  const absl::Status status = RemoveFile(BlobPath(digest));
  if (!status.ok())
    spdlog::error("damaged blob cannot be removed digest={} reason={}", digest.ToHex(),
                  LogValue(status.message()));
}

}  // namespace shutterline::server
