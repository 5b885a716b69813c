#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include "worker/engine/shading/shaded.h"
#include "worker/engine/shading/texel.h"

namespace shutterline::engine {

/// What a process gives the cache unless told otherwise. Memory is taken as it is filled.
inline constexpr size_t kDefaultShadingCacheBytes = size_t{256} << 20;

/// Shadings of texels of triangles, kept for whoever asks next [gribel2011, appendix B]: one for a whole
/// process, for all its frames and threads, of fixed size. Lock-free: a thread that finds nothing shades and
/// stores, and never waits for another. What a texel's shading is does not depend on who computes it, so
/// neither the size of the cache nor who comes first can be seen in a picture.
///
/// An entry belongs to a frame; entries of frames that have been closed are free. An entry that is there
/// stays what it is while its frame is open. Thread-safe.
class ShadingCache {
 public:
  /// Takes `bytes` of memory at most (at least one bucket), and touches none of it before it is used.
  /// RESOURCE_EXHAUSTED where so much cannot be had.
  static absl::StatusOr<std::shared_ptr<ShadingCache>> Create(size_t bytes);
  ShadingCache(const ShadingCache&) = delete;

  /// A frame's number, above 0, until it is closed.
  uint32_t OpenFrame();
  /// Nobody asks for it any more.
  void CloseFrame(uint32_t frame);

  /// True, and the shading, if it is there.
  bool Find(uint32_t frame, const TexelKey& key, Shaded& shaded) const;

  /// Has memory send what Find will want.
  void Prefetch(uint32_t frame, const TexelKey& key) const;

  enum class Outcome {
    kStored,
    kDuplicate,  ///< It was there: another thread has shaded the same meanwhile.
    kFull,       ///< There is no room for it.
  };
  Outcome Store(uint32_t frame, const TexelKey& key, const Shaded& shaded);

  size_t entries() const { return kPerBucket * buckets_; }

 private:
  /// Its state says whose it is: 0: nobody's; 2 f: frame f's, readable; 2 f + 1: one of f's threads is
  /// writing it. The rest is written only by the thread that took it, before it becomes readable.
  struct Entry {
    std::atomic<uint64_t> state;
    std::atomic<uint64_t> key_low;
    std::atomic<uint64_t> red_green;
    std::atomic<uint64_t> blue_openness;
  };
  static constexpr size_t kPerBucket = 4;  ///< Two cache lines.
  static constexpr int kGroupBits = 5;
  static constexpr size_t kGroup = size_t{1} << kGroupBits;  ///< Buckets of a page of memory.

  /// Of a readable entry.
  static uint64_t StateOf(uint32_t frame, const TexelKey& key) {
    return uint64_t{key.high} << 33 | uint64_t{frame} << 1;
  }
  /// Neighbouring texels, and the only texels of neighbouring triangles, come to lie in different buckets of
  /// one page of memory: a page that is new costs a fault or two of the system, as much as shading many
  /// texels.
  Entry* BucketOf(uint32_t frame, const TexelKey& key) const;
  bool IsFree(uint64_t state) const {
    constexpr uint64_t kFrame = (uint64_t{1} << 33) - 1;
    return (state & kFrame) < 2 * oldest_open_.load(std::memory_order_acquire);
  }

  struct Release {
    size_t bytes = 0;
    void operator()(Entry* entries) const;
  };
  using Entries = std::unique_ptr<Entry[], Release>;
  ShadingCache(size_t buckets, Entries entries) : buckets_(buckets), entries_(std::move(entries)) {}

  const size_t buckets_;  ///< A power of two.
  const Entries entries_;

  std::atomic<uint64_t> oldest_open_ = 1;  ///< No frame below is open.
  std::mutex mutex_;                       // The thread sanitizer sees through this one.
  uint64_t next_frame_ = 1;                // Guarded by mutex_.
  std::set<uint64_t> open_;                // Likewise.
};

/// A frame that is open as long as this lives.
class CachedFrame {
 public:
  /// `cache` may be null: then nothing is found or kept.
  explicit CachedFrame(std::shared_ptr<ShadingCache> cache)
      : cache_(std::move(cache)), frame_(cache_ ? cache_->OpenFrame() : 0) {}
  CachedFrame(CachedFrame&& other) noexcept : cache_(std::move(other.cache_)), frame_(other.frame_) {
    other.cache_.reset();
  }
  ~CachedFrame() {
    if (cache_) cache_->CloseFrame(frame_);
  }

  explicit operator bool() const { return cache_ != nullptr; }
  bool Find(const TexelKey& key, Shaded& shaded) const { return cache_->Find(frame_, key, shaded); }
  void Prefetch(const TexelKey& key) const { cache_->Prefetch(frame_, key); }
  ShadingCache::Outcome Store(const TexelKey& key, const Shaded& shaded) const {
    return cache_->Store(frame_, key, shaded);
  }

 private:
  std::shared_ptr<ShadingCache> cache_;
  uint32_t frame_;
};

}  // namespace shutterline::engine
