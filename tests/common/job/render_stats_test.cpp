#include "common/job/render_stats.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

namespace shutterline {
namespace {

TEST(RenderStats, EveryRowNamesAFieldOfItsOwn) {
  RenderStats stats;
  std::set<std::string> names;
  int64_t count = 0;
  for (const auto& row : kRenderCounts) {
    EXPECT_TRUE(names.insert(std::string(row.name)).second) << row.name;
    stats.*row.member = ++count;
  }
  double seconds = 0;
  for (const auto& row : kRenderSeconds) {
    EXPECT_TRUE(names.insert(std::string(row.name)).second) << row.name;
    stats.*row.member = seconds += 0.25;
  }
  // Two rows of one member would leave the value of the later one in both.
  count = 0;
  for (const auto& row : kRenderCounts) EXPECT_EQ(stats.*row.member, ++count) << row.name;
  seconds = 0;
  for (const auto& row : kRenderSeconds) EXPECT_EQ(stats.*row.member, seconds += 0.25) << row.name;

  RenderStats sum = stats;
  sum += stats;
  for (const auto& row : kRenderCounts) EXPECT_EQ(sum.*row.member, 2 * (stats.*row.member)) << row.name;
  for (const auto& row : kRenderSeconds) EXPECT_EQ(sum.*row.member, 2 * (stats.*row.member)) << row.name;
  EXPECT_EQ(sum.TotalSeconds(), 2 * stats.TotalSeconds());
}

TEST(RenderStats, SumsEndWhereAMessageDoes) {
  RenderStats large;
  large.instants = std::numeric_limits<int64_t>::max();
  large.shade_seconds = kMaxStatsSeconds;
  RenderStats sum;
  for (int i = 0; i < 3; ++i) sum += large;
  EXPECT_EQ(sum.instants, std::numeric_limits<int64_t>::max());
  EXPECT_EQ(sum.shade_seconds, kMaxStatsSeconds);
  EXPECT_EQ(sum.lines, 0);
}

}  // namespace
}  // namespace shutterline
