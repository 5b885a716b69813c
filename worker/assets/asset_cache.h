#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/container/flat_hash_map.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <string>

#include "common/asset/digest.h"
#include "worker/assets/blob_fetcher.h"

namespace shutterline::worker {

struct AssetCacheOptions {
  std::filesystem::path folder;  ///< Made if missing. Several workers of a machine may share it.
  /// What the blobs may take on disk together. Pinned blobs are kept even where they alone exceed it.
  uint64_t max_bytes = uint64_t{10} << 30;
};

/// Blobs on this machine's disk, each a file named by its SHA-256: FOLDER/ab/abcd….
///
/// A blob is checked against its name whenever it is read, so what comes out is right or an error; a
/// file that is torn or has rotted is deleted and fetched again. Files appear whole: they are written
/// under a temporary name and renamed. What does not fit is evicted, least recently used first, except
/// blobs that are pinned. Order of use survives restarts as the files' modification times.
///
/// Thread-safe. Two threads that miss the same blob may both fetch it; both succeed.
class AssetCache {
 public:
  static absl::StatusOr<std::unique_ptr<AssetCache>> Open(AssetCacheOptions options);

  AssetCache(const AssetCache&) = delete;
  AssetCache& operator=(const AssetCache&) = delete;

  /// Keeps a blob from being evicted, whether it is here already or comes later, while the pin lives.
  /// The cache must outlive its pins.
  class Pin {
   public:
    Pin(AssetCache* cache, const Digest& digest) : cache_(cache), digest_(digest) {}
    ~Pin() { cache_->Unpin(digest_); }
    Pin(const Pin&) = delete;
    Pin& operator=(const Pin&) = delete;

   private:
    AssetCache* const cache_;
    const Digest digest_;
  };
  std::unique_ptr<Pin> MakePin(const Digest& digest);

  /// The blob's bytes, from disk where they are there and intact, else from `fetcher`. DATA_LOSS where
  /// `fetcher` returns other bytes than the digest names, RESOURCE_EXHAUSTED where the blob is larger
  /// than `max_bytes`. A disk that cannot be written to costs only the caching.
  absl::StatusOr<std::string> Get(const Digest& digest, uint64_t max_bytes, BlobFetcher& fetcher);

  /// Bytes on disk that this cache knows of.
  uint64_t stored_bytes() const;
  bool Contains(const Digest& digest) const;

 private:
  struct Entry {
    uint64_t bytes = 0;
    std::list<Digest>::iterator order;
  };

  explicit AssetCache(AssetCacheOptions options) : options_(std::move(options)) {}
  absl::Status Scan();
  std::filesystem::path PathOf(const Digest& digest) const;
  /// The verified bytes on disk; NOT_FOUND where there are none (any more).
  absl::StatusOr<std::string> ReadFile(const Digest& digest, uint64_t max_bytes);
  absl::Status WriteFile(const Digest& digest, const std::string& bytes);
  void Touch(const Digest& digest, uint64_t bytes);
  void Forget(const Digest& digest);
  void Unpin(const Digest& digest);
  void EvictLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const AssetCacheOptions options_;
  mutable absl::Mutex mutex_;
  absl::flat_hash_map<Digest, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  std::list<Digest> order_ ABSL_GUARDED_BY(mutex_);  // Most recently used first.
  absl::flat_hash_map<Digest, int> pins_ ABSL_GUARDED_BY(mutex_);
  uint64_t stored_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t next_temporary_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace shutterline::worker
