#include "common/base/log_format.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <random>

#include "common/base/log.h"

namespace shutterline {
namespace {

using Fields = std::vector<std::pair<std::string, std::string>>;

TEST(LogFormatTest, TakesALineApart) {
  const LogLine line = ParseLogLine(R"(job accepted job=6f0 name="a \"b\" = c" frames=24)");
  EXPECT_EQ(line.message, "job accepted");
  EXPECT_EQ(line.fields, (Fields{{"job", "6f0"}, {"name", R"(a "b" = c)"}, {"frames", "24"}}));
}

TEST(LogFormatTest, WhatHasAnotherFormStaysInTheMessage) {
  EXPECT_EQ(ParseLogLine("no fields at all").message, "no fields at all");
  EXPECT_EQ(ParseLogLine("").message, "");
  const LogLine line = ParseLogLine("stopped signal=15 by hand");
  EXPECT_EQ(line.message, "stopped by hand");
  EXPECT_EQ(line.fields, (Fields{{"signal", "15"}}));
  EXPECT_EQ(ParseLogLine("torn reason=\"never closed").message, "torn reason=\"never closed");
}

TEST(LogFormatTest, NoValueOfAStrangerMakesAFieldOfItsOwn) {
  const unsigned seed = 20261126;
  std::mt19937 random(seed);
  for (int round = 0; round < 2000; ++round) {
    std::string value(random() % 20, ' ');
    for (char& c : value) c = "\"\\ =abc\n\x01\xff%"[random() % 12];
    const LogLine line = ParseLogLine(absl::StrCat("said name=", LogValue(value), " job=1"));
    EXPECT_EQ(line.message, "said") << "seed " << seed << ", round " << round << ": " << LogValue(value);
    ASSERT_EQ(line.fields.size(), 2u) << "seed " << seed << ", round " << round << ": " << LogValue(value);
    EXPECT_EQ(line.fields[1].second, "1");
  }
}

TEST(LogFormatTest, OtherFormatsAreRefused) {
  EXPECT_EQ(SetLogFormat("xml").code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace shutterline
