#include "worker/engine/shading/shading_cache.h"

#include <absl/strings/str_cat.h>
#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "common/base/check.h"
#include "worker/engine/shading/texel_group.h"

namespace shutterline::engine {
namespace {

/// Every bit of the result depends on every bit of `x` [the finalizer of MurmurHash3, 64 bits].
uint64_t Mix(uint64_t x) {
  x = (x ^ x >> 33) * 0xff51afd7ed558ccdu;
  x = (x ^ x >> 33) * 0xc4ceb9fe1a85ec53u;
  return x ^ x >> 33;
}

uint64_t Pack(float low, float high) {
  return uint64_t{std::bit_cast<uint32_t>(high)} << 32 | std::bit_cast<uint32_t>(low);
}
float Low(uint64_t packed) {
  return std::bit_cast<float>(uint32_t(packed));
}
float High(uint64_t packed) {
  return std::bit_cast<float>(uint32_t(packed >> 32));
}

}  // namespace

void ShadingCache::Release::operator()(Entry* entries) const {
  ::munmap(entries, bytes);
}

absl::StatusOr<std::shared_ptr<ShadingCache>> ShadingCache::Create(size_t bytes) {
  static_assert(std::atomic<uint64_t>::is_always_lock_free && sizeof(Entry) == 32);
  static_assert(kGroup * kPerBucket * sizeof(Entry) == 4096);
  const size_t buckets = std::bit_floor(std::max(bytes / (kPerBucket * sizeof(Entry)), size_t{1}));
  // Zeros are entries of nobody; the system hands out zeroed pages as they are touched.
  const size_t size = buckets * kPerBucket * sizeof(Entry);
  void* const memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    return absl::ResourceExhaustedError(absl::StrCat("shading cache: no memory for ", bytes, " bytes"));
  }
  Entries entries(static_cast<Entry*>(memory), Release{size});
  return std::shared_ptr<ShadingCache>(new ShadingCache(buckets, std::move(entries)));
}

uint32_t ShadingCache::OpenFrame() {
  const std::lock_guard lock(mutex_);
  SL_CHECK(next_frame_ < std::numeric_limits<uint32_t>::max());
  open_.insert(next_frame_);
  return uint32_t(next_frame_++);
}

void ShadingCache::CloseFrame(uint32_t frame) {
  const std::lock_guard lock(mutex_);
  open_.erase(frame);
  oldest_open_.store(open_.empty() ? next_frame_ : *open_.begin(), std::memory_order_release);
}

ShadingCache::Entry* ShadingCache::BucketOf(uint32_t frame, const TexelKey& key) const {
  const TexelGroup group = TexelGroup::Of(key, kGroupBits);
  const uint64_t hash = Mix(group.place ^ Mix(uint64_t{group.triangle} << 32 | frame));
  // Groups begin at buckets of their own choice: most have less than they have room for.
  const uint64_t member = (group.member + (hash >> (64 - kGroupBits))) % kGroup;
  return &entries_[kPerBucket * size_t((hash << kGroupBits | member) & (buckets_ - 1))];
}

void ShadingCache::Prefetch(uint32_t frame, const TexelKey& key) const {
  const Entry* bucket = BucketOf(frame, key);
  __builtin_prefetch(bucket);
  __builtin_prefetch(bucket + kPerBucket / 2);
}

bool ShadingCache::Find(uint32_t frame, const TexelKey& key, Shaded& shaded) const {
  const Entry* bucket = BucketOf(frame, key);
  const uint64_t wanted = StateOf(frame, key);
  for (size_t i = 0; i < kPerBucket; ++i) {
    const Entry& entry = bucket[i];
    if (entry.state.load(std::memory_order_acquire) != wanted) continue;
    if (entry.key_low.load(std::memory_order_relaxed) != key.low) continue;
    const uint64_t red_green = entry.red_green.load(std::memory_order_relaxed);
    const uint64_t blue_openness = entry.blue_openness.load(std::memory_order_relaxed);
    shaded = {{Low(red_green), High(red_green), Low(blue_openness)}, High(blue_openness)};
    return true;
  }
  return false;
}

ShadingCache::Outcome ShadingCache::Store(uint32_t frame, const TexelKey& key, const Shaded& shaded) {
  Entry* bucket = BucketOf(frame, key);
  const uint64_t readable = StateOf(frame, key);
  for (size_t i = 0; i < kPerBucket; ++i) {
    Entry& entry = bucket[i];
    uint64_t state = entry.state.load(std::memory_order_acquire);
    if (state == readable && entry.key_low.load(std::memory_order_relaxed) == key.low)
      return Outcome::kDuplicate;
    if (!IsFree(state)) continue;
    if (!entry.state.compare_exchange_strong(state, readable + 1, std::memory_order_acq_rel)) continue;
    entry.key_low.store(key.low, std::memory_order_relaxed);
    entry.red_green.store(Pack(shaded.radiance.x, shaded.radiance.y), std::memory_order_relaxed);
    entry.blue_openness.store(Pack(shaded.radiance.z, shaded.openness), std::memory_order_relaxed);
    entry.state.store(readable, std::memory_order_release);
    return Outcome::kStored;
  }
  return Outcome::kFull;
}

}  // namespace shutterline::engine
