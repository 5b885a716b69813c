#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "common/image/exr.h"
#include "tests/common/image/random_image.h"

namespace shutterline {
namespace {

using testing::HasSubstr;

constexpr ExrCompression kAll[] = {ExrCompression::kNone, ExrCompression::kZip, ExrCompression::kPiz,
                                   ExrCompression::kDwaa};

std::string SmallFile(ExrCompression compression) {
  return EncodeExr(RandomImage(7, 5, 11), {PixelType::kHalf, compression}, {}).value();
}

/// A file cut anywhere is refused, by name, and nothing worse happens.
TEST(ExrHostile, EveryPrefixIsAnError) {
  for (const ExrCompression compression : kAll) {
    const std::string whole = SmallFile(compression);
    ASSERT_TRUE(DecodeExr(whole, "whole.exr").ok());
    for (size_t length = 0; length < whole.size(); ++length) {
      const std::string prefix = whole.substr(0, length);
      const auto image = DecodeExr(prefix, "cut.exr");
      ASSERT_FALSE(image.ok()) << ToString(compression) << ", " << length << " of " << whole.size();
      ASSERT_THAT(std::string(image.status().message()), HasSubstr("cut.exr"));
    }
  }
}

/// Any byte replaced: an error or a picture, but never a crash or memory beyond the limits.
TEST(ExrHostile, ReplacedBytesDoNotCrash) {
  ExrLimits limits;
  limits.max_values = 1 << 20;
  const uint32_t seed = 20250;
  std::mt19937 random(seed);
  for (const ExrCompression compression : kAll) {
    const std::string whole = SmallFile(compression);
    for (size_t at = 0; at < whole.size(); ++at) {
      std::string broken = whole;
      broken[at] = char(random());
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", byte " << at);
      const auto image = DecodeExr(broken, "broken.exr", nullptr, limits);
      if (image.ok()) {
        EXPECT_LE(image->values().size(), limits.max_values);
      } else {
        EXPECT_THAT(std::string(image.status().message()), HasSubstr("broken.exr"));
      }
    }
  }
}

std::string WithWindow(const std::string& attribute, int32_t max_x, int32_t max_y) {
  std::string bytes = SmallFile(ExrCompression::kZip);
  const size_t at = bytes.find(attribute) + attribute.size() + sizeof("\0box2i\0") - 1 + 4 + 8;
  std::memcpy(&bytes[at], &max_x, 4);
  std::memcpy(&bytes[at + 4], &max_y, 4);
  return bytes;
}

TEST(ExrHostile, HugeWindowsAreRefusedBeforeAllocation) {
  for (const std::string attribute : {"dataWindow", "displayWindow"}) {
    for (const auto& [x, y] :
         {std::pair{32767, 32767}, {100000, 10}, {10, 100000}, {2147483646, 2147483646}}) {
      const auto image = DecodeExr(WithWindow(attribute, x, y), "huge.exr");
      ASSERT_FALSE(image.ok()) << attribute << " " << x << " " << y;
      EXPECT_THAT(std::string(image.status().message()), HasSubstr("huge.exr"));
    }
  }
  // Within the library's bound on sides, so it is our own limit that speaks.
  const auto image = DecodeExr(WithWindow("displayWindow", 30000, 30000), "huge.exr");
  EXPECT_EQ(image.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(image.status().message()), HasSubstr("30001 × 30001"));
}

TEST(ExrHostile, LimitsAreSettings) {
  const std::string bytes = SmallFile(ExrCompression::kZip);
  ExrLimits limits;
  limits.max_values = 7 * 5 * 4;
  EXPECT_TRUE(DecodeExr(bytes, "f", nullptr, limits).ok());
  limits.max_values -= 1;
  EXPECT_EQ(DecodeExr(bytes, "f", nullptr, limits).status().code(), absl::StatusCode::kResourceExhausted);
  limits = {};
  limits.max_channels = 3;
  EXPECT_EQ(DecodeExr(bytes, "f", nullptr, limits).status().code(), absl::StatusCode::kResourceExhausted);
}

TEST(ExrHostile, OtherFilesAreRefused) {
  EXPECT_FALSE(DecodeExr("", "f").ok());
  EXPECT_FALSE(DecodeExr("\x89PNG\r\n\x1a\n", "f").ok());
  EXPECT_FALSE(DecodeExr(std::string(10000, '\xff'), "f").ok());
}

}  // namespace
}  // namespace shutterline
