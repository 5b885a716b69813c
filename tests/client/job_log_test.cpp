#include "client/job_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace shutterline::client::job_log_test {
namespace {

using testing::ElementsAre;

const char kLog[] =
    "info: job accepted job=x frames=2\n"
    "warn: tile failed job=x frame=3 tile=17 reason=\"a tile=1\"\n"
    "warn: tile failed job=x frame=3 tile=1 reason=b\n"
    "info: frame finished job=x frame=30 bytes=9";

std::vector<std::string> Filtered(std::optional<int> frame, std::optional<int> tile,
                                  const std::vector<size_t>& cuts = {}) {
  std::vector<std::string> lines;
  LogFilter filter(frame, tile, [&](absl::string_view line) { lines.emplace_back(line); });
  const absl::string_view text = kLog;
  size_t from = 0;
  for (const size_t cut : cuts) {
    filter.Add(text.substr(from, cut - from));
    from = cut;
  }
  filter.Add(text.substr(from));
  filter.Rest();
  return lines;
}

TEST(LogFilter, KeepsWhatNamesFrameAndTile) {
  EXPECT_EQ(Filtered(std::nullopt, std::nullopt).size(), 4u);
  EXPECT_THAT(Filtered(30, std::nullopt), ElementsAre("info: frame finished job=x frame=30 bytes=9"));
  EXPECT_EQ(Filtered(3, std::nullopt).size(), 2u);
  EXPECT_THAT(Filtered(3, 17), ElementsAre("warn: tile failed job=x frame=3 tile=17 reason=\"a tile=1\""));
  EXPECT_TRUE(Filtered(30, 17).empty());
}

TEST(LogFilter, WhereTextIsCutMakesNoDifference) {
  std::mt19937 random(7);
  const auto whole = Filtered(3, std::nullopt);
  for (int round = 0; round < 100; ++round) {
    std::vector<size_t> cuts;
    for (int i = 0; i < 5; ++i)
      cuts.push_back(std::uniform_int_distribution<size_t>(0, sizeof kLog - 1)(random));
    std::sort(cuts.begin(), cuts.end());
    EXPECT_EQ(Filtered(3, std::nullopt, cuts), whole);
  }
}

}  // namespace
}  // namespace shutterline::client::job_log_test
