#include "worker/loop/result_buffer.h"

#include <absl/synchronization/notification.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "tests/support/fake_clock.h"

namespace shutterline::worker {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TileResult Result(uint32_t tile, size_t bytes = 100, std::shared_ptr<const WorkerJob> job = nullptr) {
  TileResult result;
  result.task.job = job ? job : std::make_shared<WorkerJob>();
  result.task.tile = tile;
  result.pixels.assign(bytes, 'p');
  return result;
}

std::vector<uint32_t> Tiles(const std::vector<ResultBuffer::Result>& results) {
  std::vector<uint32_t> tiles;
  for (const auto& result : results) tiles.push_back(result->task.tile);
  return tiles;
}

TEST(ResultBuffer, BatchesKeepOrderAndLimit) {
  ResultBuffer buffer(1 << 20);
  for (uint32_t tile = 0; tile < 5; ++tile) buffer.Add(Result(tile, 100));
  const size_t two = 2 * Result(0, 100).Bytes();
  const auto first = buffer.NextBatch(two);
  EXPECT_THAT(Tiles(first.results), ElementsAre(0u, 1u));
  const auto one = buffer.NextBatch(1);
  EXPECT_THAT(Tiles(one.results), ElementsAre(2u)) << "one goes however small the limit is";
  EXPECT_THAT(Tiles(buffer.NextBatch(1 << 20).results), ElementsAre(3u, 4u));
  EXPECT_EQ(buffer.size(), 5u) << "sent is not acknowledged";
}

TEST(ResultBuffer, WhatIsNotAcknowledgedIsSentAgainInOrderBeforeWhatIsNew) {
  ResultBuffer buffer(1 << 20);
  for (uint32_t tile = 0; tile < 6; ++tile) buffer.Add(Result(tile));
  const size_t two = 2 * Result(0).Bytes();
  for (int i = 0; i < 3; ++i) buffer.NextBatch(two);
  ASSERT_TRUE(buffer.Acknowledge(1, 2).ok());
  buffer.Interrupt();
  EXPECT_THAT(buffer.NextBatch(two).results, IsEmpty());
  buffer.Rewind();
  buffer.Add(Result(6));
  const auto again = buffer.NextBatch(1 << 20);
  EXPECT_EQ(again.id, 1u);
  EXPECT_THAT(Tiles(again.results), ElementsAre(2u, 3u, 4u, 5u, 6u));
  EXPECT_THAT(Tiles(*buffer.Acknowledge(1, 5)), ElementsAre(2u, 3u, 4u, 5u, 6u));
  EXPECT_TRUE(buffer.Empty());
}

TEST(ResultBuffer, AcknowledgementsThatDoNotFitAreRefused) {
  ResultBuffer buffer(1 << 20);
  EXPECT_EQ(buffer.Acknowledge(1, 0).status().code(), absl::StatusCode::kNotFound);
  buffer.Add(Result(0));
  buffer.NextBatch(1000);
  EXPECT_EQ(buffer.Acknowledge(2, 1).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(buffer.Acknowledge(1, 2).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(buffer.size(), 1u);
}

TEST(ResultBuffer, AFullBufferStopsThreadsUntilAcknowledged) {
  ResultBuffer buffer(Result(0).Bytes() * 2);
  EXPECT_TRUE(buffer.WaitForRoom());
  buffer.Add(Result(0));
  EXPECT_TRUE(buffer.WaitForRoom());
  buffer.Add(Result(1));
  absl::Notification has_room;
  std::thread renders([&] {
    EXPECT_TRUE(buffer.WaitForRoom());
    has_room.Notify();
  });
  const auto batch = buffer.NextBatch(1);
  EXPECT_FALSE(has_room.HasBeenNotified()) << "sending makes no room, only an acknowledgement does";
  ASSERT_TRUE(buffer.Acknowledge(batch.id, 1).ok());
  has_room.WaitForNotification();
  renders.join();
  buffer.Close();
  EXPECT_FALSE(buffer.WaitForRoom());
}

TEST(ResultBuffer, ResultsOfEndedJobsAreDropped) {
  ResultBuffer buffer(1 << 20);
  const auto ended = std::make_shared<WorkerJob>();
  buffer.Add(Result(0, 100, ended));
  buffer.Add(Result(1));
  ended->forgotten = true;
  EXPECT_THAT(Tiles(buffer.NextBatch(1 << 20).results), ElementsAre(1u));
  ASSERT_TRUE(buffer.Acknowledge(1, 1).ok());
  EXPECT_TRUE(buffer.Empty());
}

/// The buffer's time stands still: what is sent is sent because something has happened.
class GatheringResultBuffer : public testing::Test {
 protected:
  GatheringResultBuffer() { buffer_.SetPace(absl::Milliseconds(1)); }
  /// The next batch, as another thread that waits for it gets it while `happens` does.
  std::vector<uint32_t> NextWhile(const std::function<void()>& happens) {
    std::vector<uint32_t> tiles;
    std::thread sender([&] { tiles = Tiles(buffer_.NextBatch(1 << 20).results); });
    happens();
    sender.join();
    return tiles;
  }

  test::FakeClock clock_;
  ResultBuffer buffer_{1 << 20, clock_};
};

TEST_F(GatheringResultBuffer, ResultsWaitUntilTheirTimeHasCome) {
  EXPECT_THAT(NextWhile([&] {
                buffer_.Add(Result(0));
                buffer_.Add(Result(1));
                clock_.Advance(absl::Milliseconds(1));
              }),
              ElementsAre(0u, 1u));
}

TEST_F(GatheringResultBuffer, HurrySendsWhatWaits) {
  EXPECT_THAT(NextWhile([&] {
                buffer_.Add(Result(0));
                buffer_.Add(Result(1));
                buffer_.Hurry();
              }),
              ElementsAre(0u, 1u));
}

TEST_F(GatheringResultBuffer, AShorterPaceSendsWhatWaits) {
  buffer_.SetPace(absl::Seconds(1));
  EXPECT_THAT(NextWhile([&] {
                buffer_.Add(Result(0));
                buffer_.Add(Result(1));
                buffer_.SetPace(absl::ZeroDuration());
              }),
              ElementsAre(0u, 1u));
}

TEST_F(GatheringResultBuffer, SixteenResultsAreEnough) {
  EXPECT_EQ(NextWhile([&] {
              for (uint32_t tile = 0; tile < 16; ++tile) buffer_.Add(Result(tile));
            }).size(),
            16u);
}

TEST_F(GatheringResultBuffer, ABufferThatIsHalfFullWaitsForNothing) {
  ResultBuffer small(2 * Result(0).Bytes(), clock_);
  small.SetPace(absl::Seconds(1));
  small.Add(Result(0));
  EXPECT_THAT(Tiles(small.NextBatch(1 << 20).results), ElementsAre(0u));
}

TEST_F(GatheringResultBuffer, ANewConnectionGetsWhatWaitedAtOnce) {
  buffer_.Add(Result(0));
  buffer_.Hurry();
  buffer_.NextBatch(1 << 20);
  buffer_.Add(Result(1));
  buffer_.Rewind();
  EXPECT_THAT(Tiles(buffer_.NextBatch(1 << 20).results), ElementsAre(0u, 1u));
}

TEST_F(GatheringResultBuffer, ASenderThatWaitsForCompanyCanBeInterrupted) {
  buffer_.Add(Result(0));
  EXPECT_THAT(NextWhile([&] { buffer_.Interrupt(); }), IsEmpty());
  EXPECT_EQ(buffer_.size(), 1u);
}

}  // namespace
}  // namespace shutterline::worker
