#include "client/parse.h"

#include <gtest/gtest.h>

#include "client/human.h"
#include "client/parse_outputs.h"
#include "client/server_option.h"

namespace shutterline::client::parse_test {
namespace {

TEST(Parse, NumbersAreWholeTexts) {
  EXPECT_EQ(*ParseWhole("-5", -10, 10), -5);
  EXPECT_EQ(*ParseReal("2.5e-1", 0, 1, "x"), 0.25);
  EXPECT_EQ(*ParseUnsigned("18446744073709551615"), ~uint64_t{0});
  for (const char* text : {"", " ", "1 ", " 1", "+1", "0x1", "1e3", "1.0", "nan", "11", "-11", "1\n"}) {
    EXPECT_FALSE(ParseWhole(text, -10, 10).ok()) << text;
  }
  for (const char* text :
       {"", "nan", "-nan", "inf", "-inf", "infinity", "1e999", "0x1p3", "1,5", "1.5x", "+1"}) {
    EXPECT_FALSE(ParseReal(text, -1e300, 1e300, "x").ok()) << text;
  }
  for (const char* text : {"", "-1", "18446744073709551616", "1.5"}) EXPECT_FALSE(ParseUnsigned(text).ok());
}

TEST(Parse, FrameSize) {
  const auto size = ParseFrameSize("1920x1080");
  ASSERT_TRUE(size.ok());
  EXPECT_EQ(size->width, 1920);
  EXPECT_EQ(size->height, 1080);
  EXPECT_TRUE(ParseFrameSize("32768x1").ok());
  for (const char* text :
       {"", "x", "1024", "1024x", "x768", "0x1", "1x0", "-1x1", "1e9x1", "32769x1", "1x32769", "1024X768",
        "1024x768x2", "1024 x768", "99999999999999999999x1", "nanxnan"}) {
    EXPECT_FALSE(ParseFrameSize(text).ok()) << text;
  }
}

TEST(Parse, ShutterCurve) {
  EXPECT_TRUE(ParseShutterCurve("box")->empty());
  EXPECT_EQ(*ParseShutterCurve("triangle"), (std::vector<ShutterPoint>{{0, 0}, {0.5, 1}, {1, 0}}));
  EXPECT_EQ(*ParseShutterCurve("0:1,0.25:2.5,1:0"), (std::vector<ShutterPoint>{{0, 1}, {0.25, 2.5}, {1, 0}}));
  for (const char* word : {"box", "triangle", "trapezoid", "decay"}) {
    RenderSettings settings;
    settings.shutter_curve = *ParseShutterCurve(word);
    EXPECT_TRUE(Validate(settings).ok()) << word;
  }
  for (const char* text :
       {"", "tent", "0", "0:", ":1", "0:1,", "0:1;1:1", "-1:1,1:1", "0:nan,1:1", "0:-1,1:1"}) {
    EXPECT_FALSE(ParseShutterCurve(text).ok()) << text;
  }
}

TEST(Parse, SetsOfNames) {
  EXPECT_EQ(*ParseAovs("normal,depth"), (std::vector{Aov::kDepth, Aov::kNormal}));
  EXPECT_EQ(*ParseMattes("material,object"), (std::vector{Matte::kObject, Matte::kMaterial}));
  for (const char* text : {"", ",", "depth,", ",depth", "depth,depth", "Depth", "depth normal", "z"}) {
    EXPECT_FALSE(ParseAovs(text).ok()) << text;
  }
  for (const char* text : {"", "object,object", "objects", "asset"})
    EXPECT_FALSE(ParseMattes(text).ok()) << text;
}

TEST(Parse, Occlusion) {
  EXPECT_EQ(*ParseOcclusion("on"), OcclusionSettings());
  const OcclusionSettings expected{.lines = 8,
                                   .radius = 2.5,
                                   .falloff = OcclusionFalloff::kQuadratic,
                                   .pattern = OcclusionPattern::kPole,
                                   .motion = false};
  EXPECT_EQ(*ParseOcclusion("motion=off,lines=8,falloff=quadratic,radius=2.5,pattern=pole"), expected);
  for (const char* text :
       {"", "off", "lines", "lines=", "lines=0", "lines=1025", "lines=8,lines=8", "radius=0", "radius=nan",
        "radius=-1", "falloff=cubic", "motion=yes", "lines=8,", "samples=3"}) {
    EXPECT_FALSE(ParseOcclusion(text).ok()) << text;
  }
}

TEST(Parse, Color) {
  const auto color = ParseColor("0.5,0,12", 12);
  ASSERT_TRUE(color.ok());
  EXPECT_EQ(*color, (std::array<double, 3>{0.5, 0, 12}));
  for (const char* text :
       {"", "1", "1,1", "1,1,1,1", "1,1,", ",1,1", "1, 1,1", "-1,0,0", "0,0,13", "nan,0,0", "1;1;1", "red"}) {
    EXPECT_FALSE(ParseColor(text, 12).ok()) << text;
  }
}

TEST(Parse, HostPort) {
  for (const char* text : {"localhost:7400", "127.0.0.1:1", "farm-1.example:65535", "[::1]:7400"}) {
    EXPECT_TRUE(CheckHostPort(text).ok()) << text;
  }
  for (const char* text : {"", "localhost", ":7400", "localhost:", "localhost:0", "localhost:65536", "a b:1",
                           "unix:/tmp/x:1", "::1:7400", "[]:1", "host:7400x", "http://host:1", "host:-1"}) {
    EXPECT_FALSE(CheckHostPort(text).ok()) << text;
  }
}

TEST(Human, ThreeDigitsAndNoControlCharacters) {
  EXPECT_EQ(HumanBytes(0), "0 bytes");
  EXPECT_EQ(HumanBytes(1), "1 byte");
  EXPECT_EQ(HumanBytes(999), "999 bytes");
  EXPECT_EQ(HumanBytes(1500), "1.5 kB");
  EXPECT_EQ(HumanBytes(999'999), "1.0 MB");
  EXPECT_EQ(HumanBytes(12'345'678), "12 MB");
  EXPECT_EQ(HumanBytes(~uint64_t{0}), "18 EB");
  EXPECT_EQ(ShortDuration(absl::Seconds(59.9)), "59s");
  EXPECT_EQ(ShortDuration(absl::Seconds(127)), "2m07s");
  EXPECT_EQ(ShortDuration(absl::Minutes(65)), "1h05m");
  EXPECT_EQ(ShortDuration(absl::Seconds(-3)), "0s");
  EXPECT_EQ(Printable("a\x1b[2Jb\nc"), "a?[2Jb?c");
}

}  // namespace
}  // namespace shutterline::client::parse_test
