#include "server/assemble/tile_journal.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>
#include <spdlog/spdlog.h>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/base/status_macros.h"

namespace shutterline::server {

std::string TileJournal::SegmentPath(uint64_t segment) const {
  return absl::StrCat(folder_, "/", absl::Dec(segment, absl::kZeroPad12), ".tiles");
}

absl::StatusOr<std::unique_ptr<TileJournal>> TileJournal::Open(const std::string& folder,
                                                               const Options& options) {
  SL_RETURN_IF_ERROR(MakeFolders(folder, options.durability));
  std::unique_ptr<TileJournal> journal(new TileJournal(folder, options));
  SL_ASSIGN_OR_RETURN(const std::vector<std::string> names, ListFolder(folder));
  absl::MutexLock lock(&journal->mutex_);
  for (absl::string_view name : names) {
    uint64_t segment = 0;
    if (!absl::ConsumeSuffix(&name, ".tiles") || !absl::SimpleAtoi(name, &segment)) continue;
    journal->next_segment_ = segment + 1;  // Names are sorted.
    SL_RETURN_IF_ERROR(journal->Recover(segment));
  }
  return journal;
}

absl::Status TileJournal::Recover(uint64_t segment) {
  SL_ASSIGN_OR_RETURN(File file, File::OpenToWrite(SegmentPath(segment)));
  SL_ASSIGN_OR_RETURN(const uint64_t size, file.Size());
  const absl::StatusOr<std::string> read = file.ReadAt(0, size_t(size));
  SL_RETURN_IF_ERROR(read.status());
  const absl::string_view text = *read;
  size_t at = 0;
  int64_t whole = 0, damaged = 0;
  if (text.substr(0, kJournalHeadBytes) == kJournalHead) {
    at = kJournalHeadBytes;
    while (at < text.size()) {
      const ParsedRecord record = ParseRecord(text.substr(at));
      if (record.state == ParsedRecord::State::kTorn) break;
      if (record.state == ParsedRecord::State::kWhole) {
        const uint64_t offset = uint64_t(record.pixels.data() - text.data());
        Insert(record.address, {segment, offset, uint32_t(record.pixels.size()), record.digest});
        ++whole;
      } else {
        ++damaged;
      }
      at += record.bytes;
    }
  }
  if (at < text.size() || damaged > 0) {
    spdlog::warn("journal segment is incomplete segment={} tiles={} damaged={} cut_bytes={}", segment, whole,
                 damaged, text.size() - at);
  }
  if (at < text.size()) SL_RETURN_IF_ERROR(file.Truncate(at));
  return whole > 0 ? absl::OkStatus() : RemoveFile(SegmentPath(segment));
}

void TileJournal::Insert(const TileAddress& address, const Place& place) {
  const bool is_new = frames_[{address.job, address.frame}].emplace(address.tile, place).second;
  if (is_new) ++pinned_[place.segment];
}

TileJournal::Outcome TileJournal::Stage(const TileAddress& address, const Digest& digest,
                                        absl::string_view pixels) {
  SL_CHECK(pixels.size() <= kMaxPixelBytes);
  const std::pair<FrameKey, uint32_t> key{{address.job, address.frame}, address.tile};
  std::optional<Digest> before = Find(address);
  const auto staged = staged_digests_.find(key);
  if (!before && staged != staged_digests_.end()) before = staged->second;
  if (before) return *before == digest ? Outcome::kDuplicate : Outcome::kMismatch;
  const size_t position = AppendRecord(address, digest, pixels, staged_bytes_);
  staged_.emplace_back(address, Place{0, position, uint32_t(pixels.size()), digest});
  staged_digests_.emplace(key, digest);
  return Outcome::kStaged;
}

absl::Status TileJournal::StartSegment() {
  const uint64_t segment = next_segment_;
  SL_ASSIGN_OR_RETURN(file_, File::OpenToWrite(SegmentPath(segment)));
  file_size_ = 0;
  SL_RETURN_IF_ERROR(file_->WriteAt(0, kJournalHead));
  SL_RETURN_IF_ERROR(SyncFolder(folder_, options_.durability));
  file_size_ = kJournalHeadBytes;
  ++next_segment_;
  absl::MutexLock lock(&mutex_);
  const uint64_t before = std::exchange(current_, segment);
  if (before != 0 && pinned_[before] == 0) {
    pinned_.erase(before);
    const absl::Status status = RemoveSegment(before);
    if (!status.ok()) spdlog::warn("journal segment stays reason={}", LogValue(status.message()));
  }
  return absl::OkStatus();
}

absl::Status TileJournal::Append(absl::string_view bytes) {
  if (!file_ || file_size_ + bytes.size() > options_.max_segment_bytes) SL_RETURN_IF_ERROR(StartSegment());
  SL_RETURN_IF_ERROR(file_->WriteAt(file_size_, bytes));
  return file_->SyncData(options_.durability);
}

void TileJournal::GiveUpSegment() {
  if (!file_) return;
  // A segment that was not even begun is as good as none; its number is used again.
  const absl::Status status = file_size_ == 0 ? RemoveFile(file_->path()) : file_->Truncate(file_size_);
  if (!status.ok()) {
    // Its tiles, which nobody was told of, may come back after a restart; they are true ones.
    spdlog::warn("journal segment keeps what was not acknowledged reason={}", LogValue(status.message()));
  }
  file_.reset();
}

absl::Status TileJournal::Commit() {
  if (staged_.empty()) return absl::OkStatus();
  const absl::Status status = Annotate(Append(staged_bytes_), "journal");
  staged_digests_.clear();
  if (!status.ok()) {
    staged_bytes_.clear();
    staged_.clear();
    GiveUpSegment();
    return status;
  }
  {
    absl::MutexLock lock(&mutex_);
    for (const auto& [address, place] : staged_) {
      Insert(address, {current_, file_size_ + place.offset, place.size, place.digest});
    }
  }
  file_size_ += staged_bytes_.size();
  staged_bytes_.clear();  // Its memory serves the next group.
  staged_.clear();
  return absl::OkStatus();
}

std::vector<TileJournal::FrameKey> TileJournal::Frames() const {
  absl::MutexLock lock(&mutex_);
  std::vector<FrameKey> keys;
  for (const auto& [key, tiles] : frames_) keys.push_back(key);
  return keys;
}

std::vector<uint32_t> TileJournal::Tiles(const FrameKey& frame) const {
  absl::MutexLock lock(&mutex_);
  std::vector<uint32_t> tiles;
  const auto found = frames_.find(frame);
  if (found == frames_.end()) return tiles;
  for (const auto& [tile, place] : found->second) tiles.push_back(tile);
  return tiles;
}

std::optional<Digest> TileJournal::Find(const TileAddress& address) const {
  absl::MutexLock lock(&mutex_);
  const auto frame = frames_.find({address.job, address.frame});
  if (frame == frames_.end()) return std::nullopt;
  const auto tile = frame->second.find(address.tile);
  if (tile == frame->second.end()) return std::nullopt;
  return tile->second.digest;
}

absl::StatusOr<std::string> TileJournal::Read(const TileAddress& address) const {
  Place place;
  std::shared_ptr<const File> file;
  {
    absl::MutexLock lock(&mutex_);
    const auto frame = frames_.find({address.job, address.frame});
    if (frame == frames_.end() || !frame->second.contains(address.tile)) {
      return absl::NotFoundError(absl::StrCat("journal: tile ", address.tile, " is not here"));
    }
    place = frame->second.at(address.tile);
    SL_ASSIGN_OR_RETURN(file, SegmentToRead(place.segment));
  }
  SL_ASSIGN_OR_RETURN(std::string pixels, file->ReadAt(place.offset, place.size));
  if (pixels.size() == place.size && Sha256(pixels) == place.digest) return pixels;
  return absl::DataLossError(absl::StrCat("journal: tile ", address.tile, " is damaged in ", file->path()));
}

absl::StatusOr<std::shared_ptr<const File>> TileJournal::SegmentToRead(uint64_t segment) const {
  if (read_ == nullptr || read_segment_ != segment) {
    SL_ASSIGN_OR_RETURN(File file, File::OpenToRead(SegmentPath(segment)));
    read_ = std::make_shared<const File>(std::move(file));
    read_segment_ = segment;
  }
  return read_;
}

absl::Status TileJournal::RemoveSegment(uint64_t segment) {
  if (segment == read_segment_) read_.reset();  // Its space is free once nobody has it open.
  return RemoveFile(SegmentPath(segment));
}

void TileJournal::Unpin(const Place& place) {
  const auto pinned = pinned_.find(place.segment);
  SL_CHECK(pinned != pinned_.end() && pinned->second > 0);
  if (--pinned->second > 0 || place.segment == current_) return;
  pinned_.erase(pinned);
  const absl::Status status = RemoveSegment(place.segment);
  if (!status.ok()) spdlog::warn("journal segment stays reason={}", LogValue(status.message()));
}

void TileJournal::DropTiles(const FrameTiles& tiles) {
  for (const auto& [tile, place] : tiles) Unpin(place);
}

void TileJournal::Forget(const TileAddress& address) {
  absl::MutexLock lock(&mutex_);
  const auto frame = frames_.find({address.job, address.frame});
  if (frame == frames_.end()) return;
  const auto tile = frame->second.find(address.tile);
  if (tile == frame->second.end()) return;
  Unpin(tile->second);
  frame->second.erase(tile);
}

void TileJournal::DropFrame(const FrameKey& frame) {
  absl::MutexLock lock(&mutex_);
  const auto found = frames_.find(frame);
  if (found == frames_.end()) return;
  DropTiles(found->second);
  frames_.erase(found);
}

void TileJournal::DropJob(uint64_t job) {
  absl::MutexLock lock(&mutex_);
  auto frame = frames_.lower_bound({job, 0});
  while (frame != frames_.end() && frame->first.first == job) {
    DropTiles(frame->second);
    frame = frames_.erase(frame);
  }
}

}  // namespace shutterline::server
