#include "client/chrome_trace.h"

#include <gtest/gtest.h>

#include "proto/convert/status.h"

namespace shutterline::client::chrome_trace_test {
namespace {

void AddTile(v1::FrameTrace& frame, uint32_t tile, uint64_t lease, int64_t granted_ms, int64_t received_ms,
             int64_t render_ms) {
  v1::FrameTrace::Tile& added = *frame.add_tiles();
  added.set_tile(tile);
  added.set_lease_id(lease);
  *added.mutable_granted() = convert::ToProto(absl::Milliseconds(granted_ms));
  *added.mutable_received() = convert::ToProto(absl::Milliseconds(received_ms));
  *added.mutable_durable() = convert::ToProto(absl::Milliseconds(received_ms + 5));
  *added.mutable_render_time() = convert::ToProto(absl::Milliseconds(render_ms));
}

v1::FrameTrace Frame(int number) {
  v1::FrameTrace frame;
  frame.set_frame(number);
  frame.add_workers()->set_uuid("u");
  frame.mutable_workers(0)->set_name("one");
  return frame;
}

std::vector<Json> Tiles(const Json& trace) {
  std::vector<Json> tiles;
  for (const Json& event : trace["traceEvents"]) {
    if (event.value("cat", "") == "tile") tiles.push_back(event);
  }
  return tiles;
}

TEST(ChromeTraceTest, TilesOfALeaseThatCameTogetherAreDrawnOneAfterTheOther) {
  v1::FrameTrace frame = Frame(3);
  AddTile(frame, 7, 1, 1000, 1100, 30);
  AddTile(frame, 8, 1, 1000, 1100, 40);
  AddTile(frame, 9, 2, 1000, 1100, 80);  // Another lease at the same time: another row.
  ChromeTrace trace;
  trace.Add(frame);
  const std::vector<Json> tiles = Tiles(trace.Finish());
  ASSERT_EQ(tiles.size(), 3u);
  std::map<int, Json> by_tile;
  for (const Json& tile : tiles) by_tile[tile["args"]["tile"].get<int>()] = tile;
  // Times begin with the first grant, in microseconds.
  EXPECT_EQ(by_tile[7]["ts"], 30'000);
  EXPECT_EQ(by_tile[7]["dur"], 30'000);
  EXPECT_EQ(by_tile[8]["ts"], 60'000);
  EXPECT_EQ(by_tile[9]["ts"], 20'000);
  EXPECT_EQ(by_tile[7]["tid"], by_tile[8]["tid"]);
  EXPECT_NE(by_tile[7]["tid"], by_tile[9]["tid"]);
  EXPECT_EQ(by_tile[8]["args"]["received_us"], 100'000);
}

TEST(ChromeTraceTest, AFrameInSeveralMessagesKeepsItsWorkersAndGetsItsFile) {
  v1::FrameTrace first = Frame(3), second, other = Frame(4);
  AddTile(first, 0, 1, 0, 10, 5);
  second.set_frame(3);
  AddTile(second, 1, 1, 0, 20, 5);
  *second.mutable_assembly_began() = convert::ToProto(absl::Milliseconds(30));
  *second.mutable_assembly_ended() = convert::ToProto(absl::Milliseconds(50));
  AddTile(other, 0, 2, 20, 40, 5);
  ChromeTrace trace;
  for (const v1::FrameTrace& message : {first, second, other}) trace.Add(message);
  const Json json = trace.Finish();
  EXPECT_EQ(Tiles(json).size(), 3u);
  int files = 0, commits = 0;
  for (const Json& event : json["traceEvents"]) {
    if (event.value("cat", "") == "assembly") {
      ++files;
      EXPECT_EQ(event["dur"], 20'000);
    }
    commits += event.value("cat", "") == "commit";
  }
  EXPECT_EQ(files, 1);
  EXPECT_EQ(commits, 3);
}

TEST(ChromeTraceTest, AWorkerThatNobodyNamedIsLeftOut) {
  v1::FrameTrace frame;
  frame.set_frame(3);
  AddTile(frame, 0, 1, 0, 10, 5);
  ChromeTrace trace;
  trace.Add(frame);
  EXPECT_EQ(trace.tiles(), 0);
}

}  // namespace
}  // namespace shutterline::client::chrome_trace_test
