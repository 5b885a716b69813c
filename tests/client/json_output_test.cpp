#include "client/json_output.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace shutterline::client::json_output_test {
namespace {

std::string Documentation() {
  std::ifstream in(SHUTTERLINE_SOURCE_DIR "/docs/command_line.md");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Every key of the value and of the values in it.
void ExpectDocumented(const Json& json, const std::string& page) {
  for (const auto& [key, value] : json.items()) {
    EXPECT_NE(page.find(absl::StrCat("`", key, "`")), std::string::npos)
        << "docs/command_line.md lacks " << key;
    if (value.is_object()) ExpectDocumented(value, page);
    if (value.is_array() && !value.empty() && value.front().is_object())
      ExpectDocumented(value.front(), page);
  }
}

TEST(JsonOutput, EveryKeyIsDocumented) {
  const std::string page = Documentation();
  ASSERT_GT(page.size(), 1000u);
  v1::Job job;
  job.mutable_spec()->mutable_render();
  job.add_quarantined()->add_evidence();
  ExpectDocumented(ToJson(job), page);
  ExpectDocumented(ToJson(v1::FrameStatus()), page);
  ExpectDocumented(ToJson(v1::Worker()), page);
  ExpectDocumented(ToJson(FetchedFrame()), page);
  ExpectDocumented(ToJson(UploadReport()), page);
}

TEST(JsonOutput, WhatDoesNotExistIsNull) {
  const Json job = ToJson(v1::Job());
  for (const char* key : {"error", "submitted", "ended"}) EXPECT_TRUE(job[key].is_null()) << key;
  const Json frame = ToJson(v1::FrameStatus());
  for (const char* key : {"digest", "size_bytes"}) EXPECT_TRUE(frame[key].is_null()) << key;
  EXPECT_TRUE(ToJson(v1::Worker())["tile_seconds"].is_null());
  EXPECT_TRUE(ToJson(FetchedFrame())["preview"].is_null());
}

TEST(JsonOutput, BytesThatAreNoTextDoNotBreakADocument) {
  v1::Job job;
  job.mutable_spec()->set_name("a\xff\"b\n");
  std::ostringstream out;
  Print(ToJson(job), out, /*one_line=*/true);
  const std::string text = out.str();
  const Json back = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  ASSERT_FALSE(back.is_discarded());
  EXPECT_EQ(back["name"], "a\xEF\xBF\xBD\"b\n");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
}

}  // namespace
}  // namespace shutterline::client::json_output_test
