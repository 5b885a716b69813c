#include "worker/engine/shading/shading_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>
#include <vector>

namespace shutterline::engine {
namespace {

/// Some use both halves.
TexelKey KeyOf(uint64_t number) {
  return {number, uint32_t(number % 3) << 29};
}

/// What a key's shading is, whoever asks.
Shaded Truth(uint32_t frame, uint64_t key) {
  const auto x = float((key * 0x9e3779b97f4a7c15u >> 40) + frame);
  return {{x, -x, 2 * x + 1}, float(frame)};
}

std::shared_ptr<ShadingCache> Make(size_t bytes) {
  auto cache = ShadingCache::Create(bytes);
  EXPECT_TRUE(cache.ok()) << cache.status();
  return *cache;
}

TEST(ShadingCache, KeepsWhatIsStoredByFrameAndKey) {
  const auto cache = Make(1 << 20);
  const uint32_t one = cache->OpenFrame(), two = cache->OpenFrame();
  EXPECT_NE(one, two);
  Shaded found;
  EXPECT_FALSE(cache->Find(one, KeyOf(5), found));
  EXPECT_EQ(cache->Store(one, KeyOf(5), Truth(one, 5)), ShadingCache::Outcome::kStored);
  EXPECT_EQ(cache->Store(one, KeyOf(5), Truth(one, 5)), ShadingCache::Outcome::kDuplicate);
  ASSERT_TRUE(cache->Find(one, KeyOf(5), found));
  EXPECT_EQ(found, Truth(one, 5));
  EXPECT_FALSE(cache->Find(two, KeyOf(5), found));
  EXPECT_FALSE(cache->Find(one, KeyOf(6), found));
  // Halves of keys are not keys.
  EXPECT_FALSE(cache->Find(one, TexelKey{5, 0}, found));
  EXPECT_FALSE(cache->Find(one, TexelKey{6, KeyOf(5).high}, found));
  // Key 0 is a key.
  EXPECT_FALSE(cache->Find(one, KeyOf(0), found));
  EXPECT_EQ(cache->Store(one, KeyOf(0), Truth(one, 0)), ShadingCache::Outcome::kStored);
  EXPECT_TRUE(cache->Find(one, KeyOf(0), found));
}

TEST(ShadingCache, IsOfTheSizeThatWasAskedForAndSaysWhenItIsFull) {
  EXPECT_EQ(Make(0)->entries(), 4u);
  EXPECT_EQ(Make(1 << 20)->entries(), size_t{1 << 20} / 32);
  EXPECT_EQ(Make((1 << 20) + 12345)->entries(), size_t{1 << 20} / 32);
  const auto cache = Make(1);
  const uint32_t frame = cache->OpenFrame();
  for (uint64_t key = 1; key <= 4; ++key) {
    EXPECT_EQ(cache->Store(frame, KeyOf(key), Truth(frame, key)), ShadingCache::Outcome::kStored);
  }
  EXPECT_EQ(cache->Store(frame, KeyOf(5), Truth(frame, 5)), ShadingCache::Outcome::kFull);
  Shaded found;
  EXPECT_FALSE(cache->Find(frame, KeyOf(5), found));
  for (uint64_t key = 1; key <= 4; ++key) EXPECT_TRUE(cache->Find(frame, KeyOf(key), found));
}

TEST(ShadingCache, ClosedFramesMakeRoomOpenOnesDoNot) {
  const auto cache = Make(1);
  const uint32_t first = cache->OpenFrame();
  const uint32_t second = cache->OpenFrame();
  for (uint64_t key = 1; key <= 4; ++key) cache->Store(first, KeyOf(key), Truth(first, key));
  EXPECT_EQ(cache->Store(second, KeyOf(9), Truth(second, 9)), ShadingCache::Outcome::kFull);
  cache->CloseFrame(first);
  EXPECT_EQ(cache->Store(second, KeyOf(9), Truth(second, 9)), ShadingCache::Outcome::kStored);
  const uint32_t third = cache->OpenFrame();
  cache->CloseFrame(third);
  Shaded found;
  EXPECT_TRUE(cache->Find(second, KeyOf(9), found));
  EXPECT_EQ(found, Truth(second, 9));
}

#ifndef SHUTTERLINE_SANITIZED  // Sanitizers end the process instead.
TEST(ShadingCache, MoreThanThereIsIsAnError) {
  EXPECT_EQ(ShadingCache::Create(size_t{1} << 62).status().code(), absl::StatusCode::kResourceExhausted);
}
#endif

// Many threads over few entries, frames coming and going: whatever is found is right.
TEST(ShadingCache, NeverTellsAnythingWrongUnderContention) {
  const auto cache = Make(1 << 14);
  constexpr int kThreads = 8;
  std::atomic<int64_t> wrong = 0, hits = 0, stored = 0, duplicates = 0, full = 0;
  const auto work = [&](uint32_t seed) {
    std::mt19937 random(seed);
    for (int round = 0; round < 40; ++round) {
      const uint32_t own = cache->OpenFrame();
      for (int i = 0; i < 2000; ++i) {
        const uint64_t key = random() % 300;
        Shaded found;
        if (cache->Find(own, KeyOf(key), found)) {
          ++hits;
          if (!(found == Truth(own, key))) ++wrong;
          continue;
        }
        switch (cache->Store(own, KeyOf(key), Truth(own, key))) {
          case ShadingCache::Outcome::kStored:
            ++stored;
            break;
          case ShadingCache::Outcome::kDuplicate:
            ++duplicates;
            break;
          case ShadingCache::Outcome::kFull:
            ++full;
        }
      }
      cache->CloseFrame(own);
    }
  };
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < kThreads; ++t) threads.emplace_back(work, t + 1);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(hits, 0);
  EXPECT_GT(stored, 0);
  EXPECT_GT(full, 0);
}

// The same frame from all threads, which shade the same texels at once.
TEST(ShadingCache, ThreadsOfOneFrameShareWithoutLosingAnything) {
  const auto cache = Make(1 << 20);
  const uint32_t frame = cache->OpenFrame();
  constexpr uint64_t kKeys = 2000;
  std::atomic<int64_t> wrong = 0, shaded = 0;
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < 8; ++t) {
    threads.emplace_back([&, t] {
      std::mt19937 random(100 + t);
      for (int i = 0; i < 20'000; ++i) {
        const uint64_t key = random() % kKeys;
        Shaded found;
        if (!cache->Find(frame, KeyOf(key), found)) {
          ++shaded;
          cache->Store(frame, KeyOf(key), Truth(frame, key));
        } else if (!(found == Truth(frame, key))) {
          ++wrong;
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(shaded, int64_t(kKeys));
  // 2000 keys in 8192 buckets of four: none overflows.
  Shaded found;
  for (uint64_t key = 0; key < kKeys; ++key) EXPECT_TRUE(cache->Find(frame, KeyOf(key), found)) << key;
}

}  // namespace
}  // namespace shutterline::engine
