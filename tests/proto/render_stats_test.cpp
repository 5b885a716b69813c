#include "proto/convert/render_stats.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <iterator>
#include <limits>
#include <random>

namespace shutterline::convert {
namespace {

using google::protobuf::FieldDescriptor;
using testing::HasSubstr;

TEST(ConvertRenderStatsTest, TheMessageHasTheFieldsOfTheTablesAndNoOther) {
  const auto& message = *v1::RenderStats::descriptor();
  EXPECT_EQ(size_t(message.field_count()), std::size(kRenderCounts) + std::size(kRenderSeconds));
  for (const auto& row : kRenderCounts) {
    const FieldDescriptor* field = message.FindFieldByName(std::string(row.name));
    ASSERT_NE(field, nullptr) << row.name;
    EXPECT_EQ(field->cpp_type(), FieldDescriptor::CPPTYPE_INT64) << row.name;
  }
  for (const auto& row : kRenderSeconds) {
    const FieldDescriptor* field = message.FindFieldByName(std::string(row.name));
    ASSERT_NE(field, nullptr) << row.name;
    EXPECT_EQ(field->cpp_type(), FieldDescriptor::CPPTYPE_DOUBLE) << row.name;
  }
}

TEST(ConvertRenderStatsTest, RoundTripThroughBytesKeepsEveryField) {
  for (uint32_t seed = 1; seed <= 100; ++seed) {
    std::mt19937_64 random(seed);
    RenderStats stats;
    for (const auto& row : kRenderCounts) stats.*row.member = int64_t(random() >> (1 + random() % 63));
    for (const auto& row : kRenderSeconds) stats.*row.member = double(random() % 1000) / 7;
    v1::RenderStats message;
    ASSERT_TRUE(message.ParseFromString(ToProto(stats).SerializeAsString()));
    const absl::StatusOr<RenderStats> back = FromProto(message, "stats");
    ASSERT_TRUE(back.ok()) << "seed " << seed << ": " << back.status();
    EXPECT_EQ(*back, stats) << "seed " << seed;
  }
  EXPECT_EQ(*FromProto(v1::RenderStats(), "stats"), RenderStats());
}

TEST(ConvertRenderStatsTest, HostileValuesAreRefusedByName) {
  const auto expect_refused = [](const v1::RenderStats& message, absl::string_view name) {
    const absl::Status status = FromProto(message, "tile 3: stats").status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << name << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(absl::StrCat("tile 3: stats.", name, ": is ")));
  };
  const auto field = [](absl::string_view name) {
    return v1::RenderStats::descriptor()->FindFieldByName(std::string(name));
  };
  for (const auto& row : kRenderCounts) {
    for (const int64_t value : {int64_t{-1}, std::numeric_limits<int64_t>::min()}) {
      v1::RenderStats message;
      message.GetReflection()->SetInt64(&message, field(row.name), value);
      expect_refused(message, row.name);
    }
  }
  for (const auto& row : kRenderSeconds) {
    for (const double value :
         {-1e-9, 1.1e12, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
          std::numeric_limits<double>::quiet_NaN()}) {
      v1::RenderStats message;
      message.GetReflection()->SetDouble(&message, field(row.name), value);
      expect_refused(message, row.name);
    }
  }
}

}  // namespace
}  // namespace shutterline::convert
