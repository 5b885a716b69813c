#include "worker/loop/result_buffer.h"

#include <absl/synchronization/notification.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

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
  const auto first = buffer.NextBatch(two, absl::ZeroDuration());
  EXPECT_THAT(Tiles(first.results), ElementsAre(0u, 1u));
  const auto one = buffer.NextBatch(1, absl::ZeroDuration());
  EXPECT_THAT(Tiles(one.results), ElementsAre(2u)) << "one goes however small the limit is";
  EXPECT_THAT(Tiles(buffer.NextBatch(1 << 20, absl::ZeroDuration()).results), ElementsAre(3u, 4u));
  EXPECT_EQ(buffer.size(), 5u) << "sent is not acknowledged";
}

TEST(ResultBuffer, WhatIsInAHurryWaitsForNoCompany) {
  ResultBuffer buffer(1 << 20);
  const size_t four = 4 * Result(0).Bytes();
  buffer.Hurry();  // Nothing is here: what comes later is in no hurry.
  buffer.Add(Result(0));
  std::thread late([&] { buffer.Add(Result(1)); });
  EXPECT_THAT(Tiles(buffer.NextBatch(four, absl::InfiniteDuration()).results), ElementsAre(0u, 1u));
  late.join();
  buffer.Add(Result(2));
  buffer.Hurry();
  EXPECT_THAT(Tiles(buffer.NextBatch(four, absl::InfiniteDuration()).results), ElementsAre(2u));
  // All that is here is in a hurry, also what does not fit into the next message.
  buffer.Add(Result(3, 10'000));
  buffer.Add(Result(4));
  buffer.Hurry();
  EXPECT_THAT(Tiles(buffer.NextBatch(four, absl::InfiniteDuration()).results), ElementsAre(3u));
  EXPECT_THAT(Tiles(buffer.NextBatch(four, absl::InfiniteDuration()).results), ElementsAre(4u));
}

TEST(ResultBuffer, WhatIsNotAcknowledgedIsSentAgainInOrderBeforeWhatIsNew) {
  ResultBuffer buffer(1 << 20);
  for (uint32_t tile = 0; tile < 6; ++tile) buffer.Add(Result(tile));
  const size_t two = 2 * Result(0).Bytes();
  for (int i = 0; i < 3; ++i) buffer.NextBatch(two, absl::ZeroDuration());
  ASSERT_TRUE(buffer.Acknowledge(1, 2).ok());
  buffer.Interrupt();
  EXPECT_THAT(buffer.NextBatch(two, absl::ZeroDuration()).results, IsEmpty());
  buffer.Rewind();
  buffer.Add(Result(6));
  const auto again = buffer.NextBatch(1 << 20, absl::ZeroDuration());
  EXPECT_EQ(again.id, 1u);
  EXPECT_THAT(Tiles(again.results), ElementsAre(2u, 3u, 4u, 5u, 6u));
  EXPECT_THAT(Tiles(*buffer.Acknowledge(1, 5)), ElementsAre(2u, 3u, 4u, 5u, 6u));
  EXPECT_TRUE(buffer.Empty());
}

TEST(ResultBuffer, AcknowledgementsThatDoNotFitAreRefused) {
  ResultBuffer buffer(1 << 20);
  EXPECT_EQ(buffer.Acknowledge(1, 0).status().code(), absl::StatusCode::kNotFound);
  buffer.Add(Result(0));
  buffer.NextBatch(1000, absl::ZeroDuration());
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
  const auto batch = buffer.NextBatch(1, absl::ZeroDuration());
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
  EXPECT_THAT(Tiles(buffer.NextBatch(1 << 20, absl::ZeroDuration()).results), ElementsAre(1u));
  ASSERT_TRUE(buffer.Acknowledge(1, 1).ok());
  EXPECT_TRUE(buffer.Empty());
}

}  // namespace
}  // namespace shutterline::worker
