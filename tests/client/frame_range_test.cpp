#include "client/frame_range.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace shutterline::client::frame_range_test {
namespace {

TEST(FrameRange, ReadsWhatPeopleWrite) {
  EXPECT_EQ(*ParseFrameRange("1-48"), (FrameRange{1, 48, 1}));
  EXPECT_EQ(*ParseFrameRange("1-48x2"), (FrameRange{1, 48, 2}));
  EXPECT_EQ(*ParseFrameRange("7"), (FrameRange{7, 7, 1}));
  EXPECT_EQ(*ParseFrameRange("-3--1"), (FrameRange{-3, -1, 1}));
  EXPECT_EQ(*ParseFrameRange("-3-4x7"), (FrameRange{-3, 4, 7}));
  EXPECT_EQ(ParseFrameRange("1-48x2")->Count(), 24);
  EXPECT_EQ(ParseFrameRange("1-3x100")->Count(), 1);
}

TEST(FrameRange, RefusesEverythingElse) {
  for (const char* text : {"",
                           "-",
                           "x",
                           "5-1",
                           "1-5x0",
                           "1-5x-1",
                           "1-5x",
                           "1-5xx2",
                           "1-",
                           "-1-",
                           "1--",
                           "a-b",
                           "1..5",
                           "1-5 ",
                           " 1-5",
                           "+1-5",
                           "1-5x2x3",
                           "1-2-3",
                           "1e3-2e3",
                           "nan",
                           "inf",
                           "0x10-0x20",
                           "1000001-1000002",
                           "1-99999999999999999999",
                           "--5",
                           "1-5x99999999999",
                           "0-100000"}) {
    const auto range = ParseFrameRange(text);
    EXPECT_FALSE(range.ok()) << "'" << text << "'";
    EXPECT_EQ(range.status().code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_FALSE(range.status().message().empty()) << text;
  }
  EXPECT_TRUE(ParseFrameRange("0-99999").ok()) << "exactly the limit of frames";
}

TEST(FrameRange, OneFrame) {
  EXPECT_EQ(*ParseFrame("-12"), (FrameRange{-12, -12, 1}));
  for (const char* text : {"", "1-2", "1.5", "1x1", " 1", "1000001", "one"}) {
    EXPECT_FALSE(ParseFrame(text).ok()) << text;
  }
}

TEST(FrameRange, EveryWrittenRangeIsReadBack) {
  const uint32_t seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  for (int i = 0; i < 2000; ++i) {
    const int first = std::uniform_int_distribution<int>(-1'000'000, 999'000)(random);
    const int last = first + std::uniform_int_distribution<int>(0, 1000)(random);
    const int step = std::uniform_int_distribution<int>(1, 40)(random);
    const std::string text = std::to_string(first) + "-" + std::to_string(last) + "x" + std::to_string(step);
    const auto range = ParseFrameRange(text);
    ASSERT_TRUE(range.ok()) << text << ": " << range.status();
    EXPECT_EQ(*range, (FrameRange{first, last, step})) << text;
  }
}

}  // namespace
}  // namespace shutterline::client::frame_range_test
