#include "server/assemble/tile_journal.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>

#include "server/assemble/crc32c.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::server {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using Outcome = TileJournal::Outcome;

std::string Pixels(uint32_t tile, size_t bytes = 48) {
  return std::string(bytes, char('a' + tile % 26));
}

std::unique_ptr<TileJournal> OpenOrDie(const std::string& folder, uint64_t max_segment_bytes = 1 << 20) {
  auto journal = TileJournal::Open(folder, {.max_segment_bytes = max_segment_bytes});
  EXPECT_TRUE(journal.ok()) << journal.status();
  return *std::move(journal);
}

Outcome Stage(TileJournal& journal, const TileAddress& at, const std::string& pixels) {
  return journal.Stage(at, Sha256(pixels), pixels);
}

std::string ReadFile(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void WriteFile(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

fs::path OnlySegment(const std::string& folder) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder)) paths.push_back(entry.path());
  EXPECT_EQ(paths.size(), 1u);
  return paths.at(0);
}

size_t SegmentCount(const std::string& folder) {
  return size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(Crc32cTest, KnownAnswersOfRfc3720) {
  EXPECT_EQ(Crc32c(std::string(32, '\0')), 0x8a9136aau);
  EXPECT_EQ(Crc32c(std::string(32, '\xff')), 0x62a8ab43u);
  EXPECT_EQ(Crc32c("123456789"), 0xe3069283u);
}

TEST(TileJournalTest, CommittedTilesAreThereAfterAReopenAndUncommittedAreNot) {
  const TemporaryFolder folder;
  {
    const auto journal = OpenOrDie(folder.path());
    EXPECT_EQ(Stage(*journal, {1, 0, 3}, Pixels(3)), Outcome::kStaged);
    EXPECT_FALSE(journal->Find({1, 0, 3}).has_value());
    ASSERT_TRUE(journal->Commit().ok());
    EXPECT_EQ(Stage(*journal, {1, 0, 4}, Pixels(4)), Outcome::kStaged);
  }
  const auto journal = OpenOrDie(folder.path());
  EXPECT_EQ(journal->Read({1, 0, 3}).value(), Pixels(3));
  EXPECT_TRUE(absl::IsNotFound(journal->Read({1, 0, 4}).status()));
  EXPECT_EQ(Stage(*journal, {1, 0, 3}, Pixels(3)), Outcome::kDuplicate);
  EXPECT_EQ(Stage(*journal, {1, 0, 3}, Pixels(4)), Outcome::kMismatch);
}

TEST(TileJournalTest, FileCutAtAnyByteKeepsExactlyTheWholeRecords) {
  const TemporaryFolder folder;
  {
    const auto journal = OpenOrDie(folder.path());
    for (uint32_t tile = 0; tile < 4; ++tile) Stage(*journal, {9, 2, tile}, Pixels(tile, 16 * (tile + 1)));
    ASSERT_TRUE(journal->Commit().ok());
  }
  const fs::path segment = OnlySegment(folder.path());
  const std::string whole = ReadFile(segment);
  size_t record_end = kJournalHeadBytes;
  std::vector<size_t> ends;
  for (uint32_t tile = 0; tile < 4; ++tile) {
    record_end += kRecordHeadBytes + kBodyHeadBytes + 16 * (tile + 1);
    ends.push_back(record_end);
  }
  ASSERT_EQ(ends.back(), whole.size());
  for (size_t cut = 0; cut <= whole.size(); ++cut) {
    const TemporaryFolder copy;
    WriteFile(fs::path(copy.path()) / segment.filename(), whole.substr(0, cut));
    const auto journal = OpenOrDie(copy.path());
    const size_t expected =
        size_t(std::count_if(ends.begin(), ends.end(), [&](size_t end) { return end <= cut; }));
    const std::vector<uint32_t> tiles = journal->Tiles({9, 2});
    ASSERT_EQ(tiles.size(), expected) << "cut at " << cut;
    for (const uint32_t tile : tiles)
      ASSERT_EQ(journal->Read({9, 2, tile}).value(), Pixels(tile, 16 * (tile + 1)));
    // And it goes on from there.
    ASSERT_EQ(Stage(*journal, {9, 2, 25}, Pixels(25)), Outcome::kStaged);
    ASSERT_TRUE(journal->Commit().ok());
    ASSERT_EQ(journal->Read({9, 2, 25}).value(), Pixels(25));
  }
}

TEST(TileJournalTest, AnyFlippedByteLosesTilesButNeverChangesOne) {
  const TemporaryFolder folder;
  {
    const auto journal = OpenOrDie(folder.path());
    for (uint32_t tile = 0; tile < 3; ++tile) Stage(*journal, {1, 0, tile}, Pixels(tile));
    ASSERT_TRUE(journal->Commit().ok());
  }
  const fs::path segment = OnlySegment(folder.path());
  const std::string whole = ReadFile(segment);
  const size_t record = kRecordHeadBytes + kBodyHeadBytes + 48;
  for (size_t at = kJournalHeadBytes; at < whole.size(); ++at) {
    const TemporaryFolder copy;
    std::string damaged = whole;
    damaged[at] ^= 0x10;
    WriteFile(fs::path(copy.path()) / segment.filename(), damaged);
    const auto journal = OpenOrDie(copy.path());
    for (const auto& frame : journal->Frames()) ASSERT_EQ(frame, (TileJournal::FrameKey{1, 0}));
    for (const uint32_t tile : journal->Tiles({1, 0})) {
      ASSERT_EQ(journal->Read({1, 0, tile}).value(), Pixels(tile)) << "byte " << at;
    }
    const size_t in_record = (at - kJournalHeadBytes) % record;
    // A body that is damaged costs its own tile alone.
    if (in_record >= 4) {
      ASSERT_EQ(journal->Tiles({1, 0}).size(), 2u) << "byte " << at;
    }
  }
}

TEST(TileJournalTest, DamageAfterOpeningIsDataLossOfThatTileAlone) {
  const TemporaryFolder folder;
  const auto journal = OpenOrDie(folder.path());
  Stage(*journal, {1, 0, 0}, Pixels(0));
  Stage(*journal, {1, 0, 1}, Pixels(1));
  ASSERT_TRUE(journal->Commit().ok());
  const fs::path segment = OnlySegment(folder.path());
  std::string bytes = ReadFile(segment);
  bytes.back() ^= 1;
  WriteFile(segment, bytes);
  EXPECT_TRUE(journal->Read({1, 0, 0}).ok());
  EXPECT_TRUE(absl::IsDataLoss(journal->Read({1, 0, 1}).status()));
  journal->Forget({1, 0, 1});
  EXPECT_EQ(Stage(*journal, {1, 0, 1}, Pixels(1)), Outcome::kStaged);
  ASSERT_TRUE(journal->Commit().ok());
  EXPECT_EQ(journal->Read({1, 0, 1}).value(), Pixels(1));
}

TEST(TileJournalTest, SegmentsGoWhenNoFrameNeedsThem) {
  const TemporaryFolder folder;
  const auto journal = OpenOrDie(folder.path(), 4096);
  for (int frame = 0; frame < 40; ++frame) {
    for (uint32_t tile = 0; tile < 8; ++tile) Stage(*journal, {1, frame, tile}, Pixels(tile, 512));
    ASSERT_TRUE(journal->Commit().ok());
    journal->DropFrame({1, frame});
    ASSERT_LE(SegmentCount(folder.path()), 2u);
  }
  Stage(*journal, {2, 0, 0}, Pixels(0));
  ASSERT_TRUE(journal->Commit().ok());
  journal->DropJob(1);
  EXPECT_EQ(journal->Read({2, 0, 0}).value(), Pixels(0));
}

/// Any mix of staging, committing, forgetting and dropping leaves what a plain map says, also after
/// reopening.
TEST(TileJournalTest, AgreesWithAMapUnderRandomUse) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const TemporaryFolder folder;
    auto journal = OpenOrDie(folder.path(), 2000);
    std::map<std::tuple<uint64_t, int, uint32_t>, std::string> committed, staged;
    for (int step = 0; step < 300; ++step) {
      const TileAddress at{1 + random() % 2, int(random() % 3), uint32_t(random() % 5)};
      const auto key = std::make_tuple(at.job, at.frame, at.tile);
      switch (random() % 8) {
        case 0: {
          ASSERT_TRUE(journal->Commit().ok());
          committed.merge(staged);
          staged.clear();
          break;
        }
        case 1:
          if (!staged.empty()) break;  // As the coordinator does: frames are dropped when they are complete.
          journal->DropFrame({at.job, at.frame});
          std::erase_if(committed, [&](const auto& entry) {
            return std::get<0>(entry.first) == at.job && std::get<1>(entry.first) == at.frame;
          });
          break;
        default: {
          const std::string pixels = Pixels(uint32_t(random()), 16 * (1 + random() % 4));
          const bool known = committed.contains(key) || staged.contains(key);
          const Outcome outcome = Stage(*journal, at, pixels);
          ASSERT_EQ(outcome == Outcome::kStaged, !known);
          if (!known) staged[key] = pixels;
        }
      }
      if (step % 60 == 59) {
        staged.clear();
        journal.reset();
        journal = OpenOrDie(folder.path(), 2000);
        // What was dropped may come back with its segment, as after a crash; the coordinator drops it again.
        for (const auto& frame : journal->Frames()) {
          for (const uint32_t tile : journal->Tiles(frame)) {
            if (!committed.contains({frame.first, frame.second, tile})) {
              journal->Forget({frame.first, frame.second, tile});
            }
          }
        }
      }
    }
    for (const auto& [key, pixels] : committed) {
      const auto& [job, frame, tile] = key;
      ASSERT_TRUE(journal->Find({job, frame, tile}).has_value());
    }
  }
}

}  // namespace
}  // namespace shutterline::server
