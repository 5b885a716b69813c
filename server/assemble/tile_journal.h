#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/container/flat_hash_map.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/asset/digest.h"
#include "server/assemble/journal_record.h"
#include "server/files/file.h"

namespace shutterline::server {

/// The pixels of tiles that have come back, on disk, until their frame is written: segments, to which tiles
/// of all jobs are appended in the order in which they come, so that one flush makes a whole group durable. A
/// segment is removed when no frame needs a tile in it.
///
/// At Open all segments are read: a torn end is cut off, a damaged record is left out (its tile is rendered
/// again), and writing goes on in a new segment.
///
/// Thread-safe; but Stage and Commit are for one thread, which owns what is staged.
class TileJournal {
 public:
  using FrameKey = std::pair<uint64_t, int>;  ///< Job number, frame index.
  enum class Outcome { kStaged, kDuplicate, kMismatch };

  struct Options {
    uint64_t max_segment_bytes = uint64_t{256} << 20;
    Durability durability = Durability::kPower;
  };
  static absl::StatusOr<std::unique_ptr<TileJournal>> Open(const std::string& folder, const Options& options);

  /// Notes a tile for the next Commit, unless it is there already, with the same pixels (kDuplicate) or with
  /// others (kMismatch: the first are kept). `pixels` has at most kMaxPixelBytes.
  Outcome Stage(const TileAddress& address, const Digest& digest, absl::string_view pixels);
  /// Makes what is staged durable and visible. On failure (RESOURCE_EXHAUSTED: the disk is full) none of it
  /// is, now or after a restart where the disk still obeys, staging starts anew, and the next Commit tries
  /// again.
  absl::Status Commit();

  /// Frames with tiles here, and their tiles.
  std::vector<FrameKey> Frames() const;
  std::vector<uint32_t> Tiles(const FrameKey& frame) const;
  std::optional<Digest> Find(const TileAddress& address) const;
  /// A tile's pixels, verified. DATA_LOSS where the disk holds others, NOT_FOUND where it never came.
  absl::StatusOr<std::string> Read(const TileAddress& address) const;
  /// Forgets a tile, so that another rendering of it can be stored.
  void Forget(const TileAddress& address);
  /// The frame's tiles, all jobs' tiles of one job, are no longer needed.
  void DropFrame(const FrameKey& frame);
  void DropJob(uint64_t job);

 private:
  struct Place {
    uint64_t segment = 0;
    uint64_t offset = 0;  ///< Of the pixels in the segment's file.
    uint32_t size = 0;
    Digest digest;
  };
  using FrameTiles = absl::flat_hash_map<uint32_t, Place>;

  TileJournal(std::string folder, const Options& options) : folder_(std::move(folder)), options_(options) {}
  std::string SegmentPath(uint64_t segment) const;
  absl::Status Recover(uint64_t segment) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status StartSegment();
  absl::Status Append(absl::string_view bytes);
  /// Takes back what a failed Append has left in the file, and appends to it no more.
  void GiveUpSegment();
  void Insert(const TileAddress& address, const Place& place) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Unpin(const Place& place) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void DropTiles(const FrameTiles& tiles) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status RemoveSegment(uint64_t segment) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<std::shared_ptr<const File>> SegmentToRead(uint64_t segment) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string folder_;
  const Options options_;

  // Of the committing thread alone.
  std::string staged_bytes_;
  std::vector<std::pair<TileAddress, Place>> staged_;
  std::map<std::pair<FrameKey, uint32_t>, Digest> staged_digests_;
  std::optional<File>
      file_;  ///< The segment that is written; none before the first Commit or after a failure.
  uint64_t file_size_ = 0;
  uint64_t next_segment_ = 1;

  mutable absl::Mutex mutex_;
  std::map<FrameKey, FrameTiles> frames_ ABSL_GUARDED_BY(mutex_);
  std::map<uint64_t, int64_t> pinned_ ABSL_GUARDED_BY(mutex_);  ///< Tiles that are needed, by segment.
  uint64_t current_ ABSL_GUARDED_BY(mutex_) = 0;                ///< Segment that is written; 0: none.
  /// The segment that was read last, still open: a frame's tiles mostly lie in one.
  mutable std::shared_ptr<const File> read_ ABSL_GUARDED_BY(mutex_);
  mutable uint64_t read_segment_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace shutterline::server
