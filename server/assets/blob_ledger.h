#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/time/time.h>

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/asset/digest.h"

namespace shutterline::server {

/// What lies in an asset store: how much, what was used last, and what must stay. Keeps no files itself. Not
/// thread-safe.
class BlobLedger {
 public:
  /// What was used within `grace` stays: a scene's files come one by one, before the job that pins them all.
  explicit BlobLedger(absl::Duration grace) : grace_(grace) {}

  /// `digest` takes so many bytes from now on; it becomes the one that was used last. `now` is monotonic;
  /// -InfiniteDuration for what an earlier process left, in the order of its use.
  void Set(const Digest& digest, uint64_t bytes, absl::Duration now);
  /// It has been used; does nothing where it is not here.
  void Touch(const Digest& digest, absl::Duration now);
  void Remove(const Digest& digest);
  /// Pins count, also those of what is not here yet.
  void Pin(const Digest& digest);
  void Unpin(const Digest& digest);

  /// Bytes that all take together.
  uint64_t bytes() const { return bytes_; }
  bool Pinned(const Digest& digest) const { return pins_.contains(digest); }
  /// Those, least recently used first, whose going brings `bytes()` down to `most`; nothing where what is
  /// pinned or recent does not allow that.
  std::optional<std::vector<Digest>> Victims(uint64_t most, absl::Duration now) const;

 private:
  struct Entry {
    uint64_t bytes = 0;
    uint64_t turn = 0;  ///< Key in order_.
    absl::Duration used;
  };
  const absl::Duration grace_;
  absl::flat_hash_map<Digest, Entry> entries_;
  std::map<uint64_t, Digest> order_;  ///< By turn: least recently used first.
  absl::flat_hash_map<Digest, int> pins_;
  uint64_t bytes_ = 0;
  uint64_t next_turn_ = 1;
};

}  // namespace shutterline::server
