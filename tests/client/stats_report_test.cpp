#include "client/stats_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "proto/convert/render_stats.h"

namespace shutterline::client::stats_report_test {
namespace {

using testing::HasSubstr;
using testing::Not;

v1::FrameStatus StatusOf(int frame, const RenderStats& stats, uint32_t tiles, uint64_t bytes) {
  v1::FrameStatus status;
  status.set_frame(frame);
  status.set_tiles_total(tiles);
  status.set_size_bytes(bytes);
  *status.mutable_stats() = convert::ToProto(stats);
  return status;
}

/// Two frames of 4 tiles; of the second, one tile was not measured.
StatsReport TwoFrames() {
  RenderStats first;
  first.tiles = 4;
  first.lines = 100;
  first.instants = 250;
  first.segments = 8000;
  first.spans = 2000;
  first.resolve_seconds = 0.75;
  first.shade_seconds = 0.25;
  RenderStats second = first;
  second.tiles = 3;
  second.instants = 350;
  second.resolve_seconds = 2.75;
  return MakeStatsReport("pattern=rgls",
                         {{7, StatusOf(7, first, 4, 4000)}, {9, StatusOf(9, second, 4, 2000)}})
      .value();
}

std::string Printed(const StatsReport& report) {
  std::ostringstream out;
  PrintStats(report, out);
  return out.str();
}

TEST(StatsReport, TellsWhatFollowsFromTheCounts) {
  const Json json = ToJson(TwoFrames());
  EXPECT_EQ(json["method"], "pattern=rgls");
  ASSERT_EQ(json["frames"].size(), 2u);
  const Json& first = json["frames"][0];
  EXPECT_EQ(first["frame"], 7);
  EXPECT_EQ(first["instants_per_line"], 2.5);
  EXPECT_EQ(first["spans_per_segment"], 0.25);
  EXPECT_EQ(first["thread_seconds"], 1.0);
  EXPECT_EQ(first["tiles_per_thread_second"], 4.0);
  EXPECT_EQ(first["file_bytes_per_tile"], 1000.0);
  const Json& total = json["total"];
  EXPECT_EQ(total["tiles"], 7);
  EXPECT_EQ(total["tiles_total"], 8);
  EXPECT_EQ(total["instants_per_line"], 3.0);
  EXPECT_EQ(total["thread_seconds"], 4.0);
  EXPECT_EQ(total["file_bytes"], 6000);
}

TEST(StatsReport, EveryFieldIsInJsonAndInTheListOfAllFigures) {
  const StatsReport report = TwoFrames();
  const std::string text = Printed(report);
  const Json total = ToJson(report)["total"];
  for (const auto& row : kRenderCounts) {
    EXPECT_EQ(total[std::string(row.name)], report.Total().stats.*row.member) << row.name;
    EXPECT_THAT(text, HasSubstr("  " + std::string(row.words) + " "));
  }
  for (const auto& row : kRenderSeconds) {
    EXPECT_EQ(total[std::string(row.name)], report.Total().stats.*row.member) << row.name;
    EXPECT_THAT(text, HasSubstr("  " + std::string(row.words) + " "));
  }
}

TEST(StatsReport, TheTableHasALineAFrameAndOneOfAllWhereThereAreSeveral) {
  StatsReport report = TwoFrames();
  EXPECT_THAT(Printed(report), HasSubstr("\n      7          4"));
  EXPECT_THAT(Printed(report), HasSubstr("\n      9        3/4"));
  EXPECT_THAT(Printed(report), HasSubstr("\n    all        7/8"));
  EXPECT_THAT(Printed(report), HasSubstr("resolve                       3.500 s of thread time, 88%"));
  EXPECT_THAT(Printed(report), HasSubstr("\n1 tiles were not measured"));
  report.frames.erase(9);
  EXPECT_THAT(Printed(report), Not(HasSubstr("\n    all ")));
  EXPECT_THAT(Printed(report), Not(HasSubstr("not measured")));
}

TEST(StatsReport, NothingMeasuredIsNoDivision) {
  const StatsReport report = MakeStatsReport("m", {{1, v1::FrameStatus()}}).value();
  EXPECT_TRUE(ToJson(report)["total"]["instants_per_line"].is_null());
  EXPECT_TRUE(ToJson(report)["total"]["tiles_per_thread_second"].is_null());
  EXPECT_THAT(Printed(report), Not(HasSubstr("nan")));
  EXPECT_THAT(Printed({"m", {}}), HasSubstr("no frame is finished"));
}

TEST(StatsReport, RefusesWhatCannotBeByFrameAndField) {
  v1::FrameStatus status;
  status.mutable_stats()->set_cull_seconds(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(std::string(MakeStatsReport("m", {{3, status}}).status().message()),
              HasSubstr("frame 3: stats.cull_seconds: is nan"));
}

}  // namespace
}  // namespace shutterline::client::stats_report_test
