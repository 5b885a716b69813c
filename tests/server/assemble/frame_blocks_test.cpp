#include "server/assemble/frame_blocks.h"

#include <gtest/gtest.h>

#include <random>
#include <thread>
#include <vector>

#include "common/job/output_channels.h"

namespace shutterline::server {
namespace {

JobSpec SquareSpec(int side) {
  JobSpec spec;
  spec.render.width = spec.render.height = side;
  return spec;
}

/// A whole tile of noise, which hardly becomes smaller.
std::string Noise(uint32_t seed, size_t floats = 32 * 32 * 4) {
  std::mt19937 random(seed);
  std::vector<float> values(floats);
  for (float& value : values) value = float(random()) * 1e-9f;
  return {reinterpret_cast<const char*>(values.data()), floats * sizeof(float)};
}

void AddNoise(FrameBlocks& blocks, const FrameBlocks::FrameKey& frame, const JobSpec& spec, uint32_t tile) {
  const std::string pixels = Noise(tile);
  blocks.Add(frame, spec, tile, Sha256(pixels), pixels);
}

TEST(FrameBlocksTest, AreWhatTheEncoderMakesOfTheTiles) {
  const JobSpec spec = SquareSpec(40);  // The second tile is 8 pixels wide.
  FrameBlocks blocks({});
  const std::string narrow = Noise(9, 8 * 32 * 4);
  AddNoise(blocks, {1, 0}, spec, 0);
  blocks.Add({1, 0}, spec, 1, Sha256(narrow), narrow);
  blocks.WaitUntilIdle();
  const FrameBlocks::Blocks taken = blocks.Take({1, 0});
  ASSERT_EQ(taken.size(), 2u);
  EXPECT_EQ(taken.at(0).bytes, *BlockEncoderOf(spec).Encode(32, 32, Noise(0)));
  EXPECT_EQ(taken.at(0).pixels, Sha256(Noise(0)));
  EXPECT_EQ(taken.at(1).bytes, *BlockEncoderOf(spec).Encode(8, 32, narrow));
  EXPECT_TRUE(blocks.Take({1, 0}).empty());
}

TEST(FrameBlocksTest, MemoryIsBounded) {
  constexpr uint64_t kMost = 100'000;
  const JobSpec spec = SquareSpec(32 * 32);
  FrameBlocks blocks({.max_block_bytes = kMost, .max_waiting_bytes = 50'000});
  for (uint32_t tile = 0; tile < 300; ++tile) {
    AddNoise(blocks, {1, int(tile % 3)}, spec, tile);
    const FrameBlocks::Totals totals = blocks.totals();
    ASSERT_LE(totals.block_bytes, kMost);
    ASSERT_LE(totals.waiting_bytes, 50'000u);
    if (tile % 5 == 0) blocks.WaitUntilIdle();
  }
  blocks.WaitUntilIdle();
  EXPECT_GT(blocks.totals().block_bytes, kMost / 2);
  EXPECT_EQ(blocks.totals().waiting_bytes, 0u);
  // What is taken leaves room for others.
  blocks.DropJob(1);
  EXPECT_EQ(blocks.totals().block_bytes, 0u);
  AddNoise(blocks, {2, 0}, spec, 0);
  blocks.WaitUntilIdle();
  EXPECT_EQ(blocks.Take({2, 0}).size(), 1u);
}

TEST(FrameBlocksTest, TheLastPixelsOfATileCount) {
  const JobSpec spec = SquareSpec(32);
  FrameBlocks blocks({});
  for (const uint32_t seed : {1u, 2u, 3u}) blocks.Add({1, 0}, spec, 0, Sha256(Noise(seed)), Noise(seed));
  blocks.WaitUntilIdle();
  const uint64_t bytes = blocks.totals().block_bytes;
  const FrameBlocks::Blocks taken = blocks.Take({1, 0});
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken.at(0).pixels, Sha256(Noise(3)));
  EXPECT_GT(bytes, taken.at(0).bytes.size());
  EXPECT_LT(bytes, 2 * taken.at(0).bytes.size()) << "counted once";
  EXPECT_EQ(blocks.totals().block_bytes, 0u);
}

TEST(FrameBlocksTest, NothingIsMadeWhereNothingMayBeKeptOrNothingIsCompressed) {
  JobSpec spec = SquareSpec(32);
  FrameBlocks none({.max_block_bytes = 0});
  AddNoise(none, {1, 0}, spec, 0);
  none.WaitUntilIdle();
  EXPECT_TRUE(none.Take({1, 0}).empty());
  spec.output.compression = ExrCompression::kNone;
  FrameBlocks blocks({});
  AddNoise(blocks, {1, 0}, spec, 0);
  blocks.WaitUntilIdle();
  EXPECT_TRUE(blocks.Take({1, 0}).empty());
}

TEST(FrameBlocksTest, JobsAndFramesAreDroppedApart) {
  const JobSpec spec = SquareSpec(64);
  FrameBlocks blocks({});
  for (const uint64_t job : {1, 2, 3}) {
    for (const int frame : {0, 1}) AddNoise(blocks, {job, frame}, spec, 0);
  }
  blocks.WaitUntilIdle();
  EXPECT_EQ(blocks.totals().frames, 6u);
  blocks.DropJob(2);
  blocks.Take({3, 0});
  EXPECT_EQ(blocks.totals().frames, 3u);
  EXPECT_EQ(blocks.Take({1, 0}).size(), 1u);
  EXPECT_EQ(blocks.Take({1, 1}).size(), 1u);
  EXPECT_EQ(blocks.Take({3, 1}).size(), 1u);
  EXPECT_EQ(blocks.totals().block_bytes, 0u);
}

TEST(FrameBlocksTest, WhatIsTakenWhileOthersAddIsCountedOnce) {
  const JobSpec spec = SquareSpec(1024);
  FrameBlocks blocks({});
  std::vector<std::thread> threads;
  for (int frame = 0; frame < 3; ++frame) {
    threads.emplace_back([&, frame] {
      for (uint32_t tile = 0; tile < 40; ++tile) {
        AddNoise(blocks, {1, frame}, spec, tile);
        if (tile % 7 == 6) blocks.Take({1, frame});
        if (tile % 11 == 10) blocks.DropJob(1);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  blocks.WaitUntilIdle();
  blocks.DropJob(1);
  const FrameBlocks::Totals totals = blocks.totals();
  EXPECT_EQ(totals.block_bytes, 0u);
  EXPECT_EQ(totals.waiting_bytes, 0u);
  EXPECT_EQ(totals.frames, 0u);
}

}  // namespace
}  // namespace shutterline::server
