#include "server/assemble/frame_assembler.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <random>

#include "common/image/exr.h"
#include "common/job/output_channels.h"
#include "common/job/tile.h"
#include "server/assemble/frame_blocks.h"
#include "server/assemble/tile_journal.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::server {
namespace {

using test::TemporaryFolder;
using testing::ElementsAre;

constexpr TileJournal::FrameKey kFrame{3, 0};

std::string FileBytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A frame of 5 × 3 tiles, some of them cut, with channels of both pixel types.
JobSpec SpecOf(ExrCompression compression) {
  JobSpec spec;
  spec.scene.root_name = "scene.glb";
  spec.frames = {7, 7, 1};
  spec.render.width = 150;
  spec.render.height = 70;
  spec.render.aovs = {Aov::kDepth, Aov::kNormal};
  spec.output.compression = compression;
  return spec;
}

class FrameAssemblerTest : public testing::Test {
 protected:
  FrameAssemblerTest() { OpenJournal(); }

  void OpenJournal() {
    journal_.reset();
    auto journal = TileJournal::Open(folder_.path() + "/journal", {});
    ASSERT_TRUE(journal.ok()) << journal.status();
    journal_ = *std::move(journal);
  }

  TileGrid grid() const { return {spec_.render.width, spec_.render.height}; }
  std::vector<uint32_t> AllTiles() const {
    std::vector<uint32_t> tiles(size_t(grid().Count()));
    std::iota(tiles.begin(), tiles.end(), 0u);
    return tiles;
  }

  /// The tile as a worker sends it: a pattern with noise.
  std::string Pixels(uint32_t tile, uint32_t seed = 1) const {
    const size_t count = size_t(grid().Rect(int(tile)).Area()) * size_t(OutputChannelCount(spec_.render));
    std::mt19937 random(seed * 1000 + tile);
    std::uniform_real_distribution<float> noise(0, 1);
    std::vector<float> values(count);
    for (size_t i = 0; i < count; ++i) values[i] = i % 3 == 0 ? noise(random) : float(tile);
    return {reinterpret_cast<const char*>(values.data()), count * sizeof(float)};
  }

  void Store(const std::vector<uint32_t>& tiles, FrameBlocks* blocks) {
    for (const uint32_t tile : tiles) {
      const std::string pixels = Pixels(tile);
      const Digest digest = Sha256(pixels);
      ASSERT_EQ(journal_->Stage({kFrame.first, kFrame.second, tile}, digest, pixels),
                TileJournal::Outcome::kStaged);
      ASSERT_TRUE(journal_->Commit().ok());
      if (blocks != nullptr) blocks->Add(kFrame, spec_, tile, digest, pixels);
    }
  }

  absl::StatusOr<AssembledFrame> Assemble(FrameBlocks::Blocks blocks,
                                          const std::set<uint32_t>& missing = {}) {
    const FrameFacts facts{.names = [] { return MatteNames(); }, .camera = [] { return CameraMatrices(); }};
    return AssembleFrame(*journal_, kFrame, spec_, missing, std::move(blocks), facts, path(),
                         Durability::kProcess);
  }
  std::string path() const { return folder_.path() + "/frame.exr"; }

  /// The file from tiles of the journal alone, in the order of the picture.
  std::string Reference() {
    Store(AllTiles(), nullptr);
    const auto frame = Assemble({});
    EXPECT_TRUE(frame.ok()) << frame.status();
    const std::string bytes = FileBytes(path());
    EXPECT_EQ(frame->size, bytes.size());
    EXPECT_EQ(frame->digest, Sha256(bytes));
    std::filesystem::remove(path());
    journal_.reset();
    std::filesystem::remove_all(folder_.path() + "/journal");
    OpenJournal();
    return bytes;
  }

  TemporaryFolder folder_;
  JobSpec spec_ = SpecOf(ExrCompression::kZip);
  std::unique_ptr<TileJournal> journal_;
};

TEST_F(FrameAssemblerTest, HoldsThePixelsThatCame) {
  spec_.output.pixel_type = PixelType::kFloat;
  const std::string bytes = Reference();
  const auto image = DecodeExr(bytes, "the frame");
  ASSERT_TRUE(image.ok()) << image.status();
  std::map<std::string, size_t> place;  // The file's order of channels is another than a tile's.
  for (size_t c = 0; c < image->channels().size(); ++c) place[image->channels()[c]] = c;
  const std::vector<OutputChannel> channels = OutputChannelsOf(spec_.render);
  ASSERT_EQ(place.size(), channels.size());
  for (const uint32_t tile : AllTiles()) {
    const TileRect rect = grid().Rect(int(tile));
    const std::string pixels = Pixels(tile);
    const char* next = pixels.data();
    for (int y = 0; y < rect.height; ++y) {
      for (int x = 0; x < rect.width; ++x) {
        for (const OutputChannel& channel : channels) {
          float value;
          std::memcpy(&value, next, sizeof value);
          next += sizeof value;
          ASSERT_EQ(image->At(rect.x + x, rect.y + y)[place[channel.name]], value) << tile << channel.name;
        }
      }
    }
  }
}

TEST_F(FrameAssemblerTest, BytesDependNeitherOnTheOrderOfTilesNorOnWhatWasCompressedBefore) {
  for (const ExrCompression compression :
       {ExrCompression::kNone, ExrCompression::kZip, ExrCompression::kPiz, ExrCompression::kDwaa}) {
    spec_ = SpecOf(compression);
    const std::string reference = Reference();
    for (uint32_t seed = 1; seed <= 6; ++seed) {
      std::vector<uint32_t> order = AllTiles();
      std::shuffle(order.begin(), order.end(), std::mt19937(seed));
      // All blocks, some, or few: as far as the memory goes and the thread comes.
      FrameBlocks blocks({.max_block_bytes = seed % 2 == 0 ? uint64_t{1} << 30 : 20'000});
      Store(order, &blocks);
      if (seed > 2) blocks.WaitUntilIdle();
      const auto frame = Assemble(blocks.Take(kFrame));
      ASSERT_TRUE(frame.ok()) << frame.status();
      EXPECT_TRUE(FileBytes(path()) == reference) << "seed " << seed << " compression " << int(compression);
      journal_->DropFrame(kFrame);
    }
  }
}

TEST_F(FrameAssemblerTest, ARestartInMidFrameChangesNoByte) {
  const std::string reference = Reference();
  std::vector<uint32_t> order = AllTiles();
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  const std::vector<uint32_t> before(order.begin(), order.begin() + 8), after(order.begin() + 8, order.end());
  {
    FrameBlocks lost({});
    Store(before, &lost);
    lost.WaitUntilIdle();
  }
  OpenJournal();
  FrameBlocks blocks({});
  Store(after, &blocks);
  blocks.WaitUntilIdle();
  FrameBlocks::Blocks ready = blocks.Take(kFrame);
  EXPECT_EQ(ready.size(), after.size());
  const auto frame = Assemble(std::move(ready));
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_TRUE(FileBytes(path()) == reference);
}

TEST_F(FrameAssemblerTest, ABlockOfOtherPixelsThanTheJournalHasIsNotUsed) {
  const std::string reference = Reference();
  Store(AllTiles(), nullptr);
  FrameBlocks blocks({});
  for (const uint32_t tile : AllTiles()) {
    const std::string other = Pixels(tile, 2);
    blocks.Add(kFrame, spec_, tile, Sha256(other), other);
  }
  blocks.WaitUntilIdle();
  FrameBlocks::Blocks ready = blocks.Take(kFrame);
  EXPECT_EQ(ready.size(), AllTiles().size());
  ASSERT_TRUE(Assemble(std::move(ready)).ok());
  EXPECT_TRUE(FileBytes(path()) == reference);
}

TEST_F(FrameAssemblerTest, WhatTheJournalLacksIsNotWrittenHoweverReadyItIs) {
  FrameBlocks blocks({});
  Store(AllTiles(), &blocks);
  blocks.WaitUntilIdle();
  journal_->Forget({kFrame.first, kFrame.second, 11});
  journal_->Forget({kFrame.first, kFrame.second, 2});
  const auto frame = Assemble(blocks.Take(kFrame));
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_THAT(frame->lost_tiles, ElementsAre(2u, 11u));
  EXPECT_FALSE(std::filesystem::exists(path()));
}

TEST_F(FrameAssemblerTest, DamagedRecordsAreLostUnlessTheirBlocksAreReady) {
  FrameBlocks blocks({});
  Store({0, 1, 2, 3, 4}, &blocks);
  Store({5, 6, 7, 8, 9, 10, 11, 12, 13, 14}, nullptr);
  blocks.WaitUntilIdle();
  const std::string segment = folder_.path() + "/journal/000000000002.tiles";
  const std::string name =
      std::filesystem::exists(segment) ? segment : folder_.path() + "/journal/000000000001.tiles";
  const std::string bytes = FileBytes(name);
  ASSERT_FALSE(bytes.empty());
  std::string damaged = bytes;
  for (const uint32_t tile : {1u, 8u}) {
    const size_t at = bytes.find(Pixels(tile));
    ASSERT_NE(at, std::string::npos);
    damaged[at + 5] = char(damaged[at + 5] ^ 1);
  }
  std::ofstream(name, std::ios::binary | std::ios::in).write(damaged.data(), std::streamsize(damaged.size()));
  const auto frame = Assemble(blocks.Take(kFrame));
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_THAT(frame->lost_tiles, ElementsAre(8u));
}

TEST_F(FrameAssemblerTest, MissingTilesAreTransparentAndNamed) {
  FrameBlocks blocks({});
  std::vector<uint32_t> tiles = AllTiles();
  std::erase_if(tiles, [](uint32_t tile) { return tile == 4 || tile == 13; });
  Store(tiles, &blocks);
  blocks.WaitUntilIdle();
  const auto frame = Assemble(blocks.Take(kFrame), {4, 13});
  ASSERT_TRUE(frame.ok()) << frame.status();
  ASSERT_TRUE(frame->lost_tiles.empty());
  ExrMetadata metadata;
  const auto image = ReadExr(path(), &metadata);
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_EQ(metadata.strings["shutterline:missing_tiles"], "4,13");
  for (const int tile : {4, 13}) {
    const TileRect rect = grid().Rect(tile);
    for (int c = 0; c < image->channel_count(); ++c) EXPECT_EQ(image->At(rect.x, rect.y)[c], 0.f) << tile;
  }
}

}  // namespace
}  // namespace shutterline::server
