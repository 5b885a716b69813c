#include "server/observe/timeline.h"

#include <gtest/gtest.h>

namespace shutterline::server {
namespace {

const absl::Duration kStart = absl::Seconds(100);

void Grant(Timeline& timeline, const std::string& job, int frame, WorkerId worker,
           const std::vector<uint32_t>& tiles, absl::Duration at) {
  timeline.OnGranted({7, worker, "uuid", "name", job, frame, tiles, at});
}

void Store(Timeline& timeline, const std::string& job, int frame, WorkerId worker, uint32_t tile,
           absl::Duration at, absl::Duration took) {
  timeline.OnTileStored({job, frame, tile, worker, at, at + absl::Milliseconds(3), took});
}

TEST(TimelineTest, TellsWhoRenderedWhichTileWhen) {
  Timeline timeline;
  Grant(timeline, "a", 3, 1, {0, 1}, kStart);
  Store(timeline, "a", 3, 1, 1, kStart + absl::Seconds(2), absl::Seconds(1));
  Store(timeline, "a", 3, 2, 5, kStart + absl::Seconds(4), absl::Seconds(3));  // Its grant was not seen.
  timeline.OnFrameWritten({"a", 3, 1000, kStart + absl::Seconds(5), kStart + absl::Seconds(6)});
  const std::optional<FrameTimeline> frame = timeline.Find("a", 3);
  ASSERT_TRUE(frame.has_value());
  ASSERT_EQ(frame->tiles.size(), 2u);
  EXPECT_EQ(frame->tiles[0].tile, 1u);
  EXPECT_EQ(frame->tiles[0].lease, 7u);
  EXPECT_EQ(frame->tiles[0].granted, kStart);
  EXPECT_EQ(frame->tiles[0].durable - frame->tiles[0].received, absl::Milliseconds(3));
  EXPECT_EQ(frame->workers[frame->tiles[0].worker].name, "name");
  EXPECT_EQ(frame->tiles[1].lease, 0u);
  EXPECT_EQ(frame->tiles[1].granted, kStart + absl::Seconds(1));
  ASSERT_TRUE(frame->assembly.has_value());
  EXPECT_EQ(frame->assembly->second, kStart + absl::Seconds(6));
  EXPECT_EQ(timeline.entries(), 2u);  // The grant of tile 0 is forgotten with the frame's end.
  EXPECT_FALSE(timeline.Find("a", 4).has_value());
  EXPECT_EQ(timeline.Frames("a"), std::vector<int>{3});
}

TEST(TimelineTest, GoesOnWhereAReaderStopped) {
  Timeline timeline;
  for (uint32_t tile = 0; tile < 5; ++tile) Store(timeline, "a", 0, 1, tile, kStart, absl::Seconds(1));
  const auto rest = timeline.Find("a", 0, 3);
  ASSERT_EQ(rest->tiles.size(), 2u);
  EXPECT_EQ(rest->skipped, 3u);
  EXPECT_EQ(rest->tiles[0].tile, 3u);
  EXPECT_EQ(timeline.Find("a", 0, 99)->skipped, 5u);
}

TEST(TimelineTest, IsBoundedAndForgetsWhatBeganFirst) {
  Timeline timeline(100);
  for (int frame = 0; frame < 30; ++frame) {
    for (uint32_t tile = 0; tile < 10; ++tile) {
      Grant(timeline, "a", frame, 1, {tile}, kStart);
      Store(timeline, "a", frame, 1, tile, kStart, absl::Seconds(1));
      EXPECT_LE(timeline.entries(), 100u);
    }
  }
  EXPECT_EQ(timeline.Frames("a").size(), 10u);
  EXPECT_EQ(timeline.Frames("a").front(), 20);
  const uint64_t before = timeline.Find("a", 29)->id;
  // One frame that is larger than all there is room for.
  for (uint32_t tile = 0; tile < 1000; ++tile) Grant(timeline, "b", 0, 1, {tile}, kStart);
  EXPECT_LE(timeline.entries(), 100u);
  Store(timeline, "a", 29, 1, 0, kStart, absl::Seconds(1));
  EXPECT_NE(timeline.Find("a", 29)->id, before);
  timeline.OnJobEnded("b", JobState::kCancelled);
  EXPECT_LE(timeline.entries(), 1u);
}

}  // namespace
}  // namespace shutterline::server
