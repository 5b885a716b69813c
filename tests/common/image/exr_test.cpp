#include "common/image/exr.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <half.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <tuple>

#include "tests/common/image/random_image.h"

namespace shutterline {
namespace {

using testing::HasSubstr;

class Folder {
 public:
  Folder()
      : path_(std::filesystem::temp_directory_path() /
              ("shutterline-exr-" + std::to_string(getpid()) + "-" +
               testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string File(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

using Case = std::tuple<PixelType, ExrCompression, std::pair<int, int>>;
class RoundTrip : public testing::TestWithParam<Case> {};

TEST_P(RoundTrip, KeepsWhatThePixelTypeHolds) {
  const auto [type, compression, size] = GetParam();
  const Image image = RandomImage(size.first, size.second, 7, 0, 4);
  const absl::StatusOr<std::string> bytes = EncodeExr(image, {type, compression}, {});
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  const absl::StatusOr<Image> back = DecodeExr(*bytes, "memory");
  ASSERT_TRUE(back.ok()) << back.status();
  ASSERT_EQ(back->width(), image.width());
  ASSERT_EQ(back->height(), image.height());
  ASSERT_EQ(back->channels(), image.channels());
  const bool lossless = compression != ExrCompression::kDwaa;
  for (size_t i = 0; i < image.values().size(); ++i) {
    const float want = type == PixelType::kHalf ? float(half(image.values()[i])) : image.values()[i];
    if (lossless) {
      ASSERT_EQ(back->values()[i], want) << "value " << i;
    } else {
      // DWAA quantises the cosine transform of perceptual values: noise of full contrast is its worst case.
      ASSERT_NEAR(back->values()[i], want, 0.1) << "value " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, RoundTrip,
                         testing::Combine(testing::Values(PixelType::kHalf, PixelType::kFloat),
                                          testing::Values(ExrCompression::kNone, ExrCompression::kZip,
                                                          ExrCompression::kPiz, ExrCompression::kDwaa),
                                          testing::Values(std::pair(1, 1), std::pair(33, 31),
                                                          std::pair(32, 64), std::pair(100, 3))));

TEST(Exr, IsTiledAndDeterministic) {
  const Image image = RandomImage(70, 40, 3);
  ExrMetadata metadata;
  metadata.strings["shutterline:build"] = "b";
  const auto first = EncodeExr(image, {}, metadata), second = EncodeExr(image, {}, metadata);
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(*first, *second);
  // Magic number, then version 2 with the bit for tiles (0x200), little-endian.
  EXPECT_EQ(first->substr(0, 4), std::string("\x76\x2f\x31\x01"));
  EXPECT_EQ((*first)[4], 2);
  EXPECT_EQ((*first)[5] & 2, 2);
  const size_t tiles = first->find("tiles");
  ASSERT_NE(tiles, std::string::npos);
  // "tiles\0tiledesc\0", size 9, then width and height.
  EXPECT_EQ(first->substr(tiles, 15), std::string("tiles\0tiledesc\0", 15));
  EXPECT_EQ((*first)[tiles + 19], 32);
  EXPECT_EQ((*first)[tiles + 23], 32);
}

TEST(Exr, ThreadsChangeNoByte) {
  const Image image = RandomImage(300, 200, 5);
  for (const ExrCompression compression :
       {ExrCompression::kNone, ExrCompression::kZip, ExrCompression::kPiz, ExrCompression::kDwaa}) {
    SetExrThreads(0);
    const auto alone = EncodeExr(image, {PixelType::kHalf, compression}, {});
    ASSERT_TRUE(alone.ok()) << alone.status();
    for (const int threads : {1, 3, 8}) {
      SetExrThreads(threads);
      const auto together = EncodeExr(image, {PixelType::kHalf, compression}, {});
      ASSERT_TRUE(together.ok()) << together.status();
      EXPECT_EQ(*alone, *together) << threads << " threads, compression " << int(compression);
    }
  }
  SetExrThreads(0);
}

TEST(Exr, MetadataRoundTrip) {
  ExrMetadata metadata;
  metadata.pixel_aspect_ratio = 1.5f;
  metadata.frames_per_second = FrameRateOf(23.976);
  metadata.capture_date = "2020:01:02 03:04:05";
  M44d matrix;
  matrix[3][0] = 0.25;
  matrix[0][1] = -8;
  metadata.world_to_camera = matrix;
  metadata.world_to_ndc = matrix.transposed();
  metadata.strings = {{"shutterline:settings", "{\"width\":3}"},
                      {"shutterline:build", ""},
                      {"shutterline:an attribute's name of more than thirty-one bytes", "long"}};
  const auto bytes = EncodeExr(RandomImage(3, 2, 1), {}, metadata);
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  ExrMetadata back;
  ASSERT_TRUE(DecodeExr(*bytes, "memory", &back).ok());
  EXPECT_EQ(back.pixel_aspect_ratio, 1.5f);
  EXPECT_EQ(back.frames_per_second, (FrameRate{24000, 1001}));
  EXPECT_EQ(back.capture_date, metadata.capture_date);
  EXPECT_EQ(back.world_to_camera, metadata.world_to_camera);
  EXPECT_EQ(back.world_to_ndc, metadata.world_to_ndc);
  EXPECT_EQ(back.strings, metadata.strings);
}

TEST(Exr, FrameRatesAreExact) {
  EXPECT_EQ(FrameRateOf(24), (FrameRate{24, 1}));
  EXPECT_EQ(FrameRateOf(29.97), (FrameRate{30000, 1001}));
  EXPECT_EQ(FrameRateOf(12.5), (FrameRate{25, 2}));
}

TEST(Exr, RefusesBrokenMetadata) {
  const Image image(2, 2);
  for (const char* name : {"channels", "compression", "dataWindow", "tiles", ""}) {
    ExrMetadata metadata;
    metadata.strings[name] = "x";
    const auto result = EncodeExr(image, {}, metadata);
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument) << "'" << name << "'";
  }
  ExrMetadata metadata;
  metadata.frames_per_second = FrameRate{24, 0};
  EXPECT_THAT(std::string(EncodeExr(image, {}, metadata).status().message()), HasSubstr("24/0"));
}

TEST(Exr, RefusesImagesThatAreNone) {
  EXPECT_EQ(EncodeExr(Image(), {}, {}).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(EncodeExr(Image(0, 3), {}, {}).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(EncodeExr(Image(2, 2, {}), {}, {}).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(EncodeExr(Image(2, 2, {"R", "R"}), {}, {}).status().message()), HasSubstr("'R'"));
}

TEST(Exr, HalfStaysFinite) {
  Image image(2, 1, {"R"});
  image.values() = {1e30f, -70000.0f};
  const auto back = DecodeExr(EncodeExr(image, {}, {}).value(), "memory");
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->values(), (std::vector<float>{65504, -65504}));
  image.values() = {std::numeric_limits<float>::infinity(), std::nanf("")};
  const auto special = DecodeExr(EncodeExr(image, {}, {}).value(), "memory");
  EXPECT_TRUE(std::isinf(special->values()[0]));
  EXPECT_TRUE(std::isnan(special->values()[1]));
}

TEST(Exr, OtherChannelsFollowColours) {
  const Image image = RandomImage(5, 4, 2, 0, 1, {"B", "Z", "R", "AO", "G"});
  const auto back = DecodeExr(EncodeExr(image, {PixelType::kFloat, {}}, {}).value(), "memory");
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->channels(), (std::vector<std::string>{"R", "G", "B", "AO", "Z"}));
  EXPECT_EQ(back->At(3, 2)[0], image.At(3, 2)[2]);
  EXPECT_EQ(back->At(3, 2)[4], image.At(3, 2)[1]);
}

/// Scanlines, mixed pixel types and windows that differ: written with the library itself.
TEST(Exr, ReadsScanlinesOfAllTypesIntoTheDisplayWindow) {
  const Folder folder;
  const std::string path = folder.File("scan.exr");
  {
    Imf::Header header(Imath::Box2i({10, 20}, {13, 22}), Imath::Box2i({9, 21}, {11, 24}));
    header.channels().insert("R", Imf::Channel(Imf::HALF));
    header.channels().insert("G", Imf::Channel(Imf::FLOAT));
    header.channels().insert("id", Imf::Channel(Imf::UINT));
    std::vector<half> r(12);
    std::vector<float> g(12);
    std::vector<unsigned> id(12);
    for (int y = 21; y <= 24; ++y) {
      for (int x = 9; x <= 11; ++x) {
        const size_t i = size_t((y - 21) * 3 + (x - 9));
        r[i] = half(float(x));
        g[i] = float(y) + 0.125f;
        id[i] = unsigned(100 * x + y);
      }
    }
    Imf::FrameBuffer frame;
    const Imath::Box2i window = header.dataWindow();
    frame.insert("R", Imf::Slice::Make(Imf::HALF, r.data(), window));
    frame.insert("G", Imf::Slice::Make(Imf::FLOAT, g.data(), window));
    frame.insert("id", Imf::Slice::Make(Imf::UINT, id.data(), window));
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(4);
  }
  const auto image = ReadExr(path);
  ASSERT_TRUE(image.ok()) << image.status();
  ASSERT_EQ(image->width(), 4);
  ASSERT_EQ(image->height(), 3);
  ASSERT_EQ(image->channels(), (std::vector<std::string>{"R", "G", "id"}));
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) {
      const int px = x + 10, py = y + 20;
      const bool inside = px <= 11 && py >= 21;
      EXPECT_EQ(image->At(x, y)[0], inside ? float(px) : 0.0f);
      EXPECT_EQ(image->At(x, y)[1], inside ? float(py) + 0.125f : 0.0f);
      EXPECT_EQ(image->At(x, y)[2], inside ? float(100 * px + py) : 0.0f);
    }
  }
}

TEST(Exr, WritesFilesWholeOrNotAtAll) {
  const Folder folder;
  const Image image = RandomImage(40, 40, 5);
  ASSERT_TRUE(WriteExr(folder.File("a.exr"), image, {}, {}).ok());
  ASSERT_TRUE(ReadExr(folder.File("a.exr")).ok());
  const absl::Status missing = WriteExr(folder.File("none/a.exr"), image, {}, {});
  EXPECT_EQ(missing.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.message()), HasSubstr("none/a.exr"));
  // A failing encoder touches no file.
  EXPECT_FALSE(WriteExr(folder.File("a.exr"), Image(), {}, {}).ok());
  EXPECT_TRUE(ReadExr(folder.File("a.exr")).ok());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.File("")), {}), 1);
}

TEST(Exr, ErrorsNameTheFile) {
  const Folder folder;
  const absl::Status missing = ReadExr(folder.File("no.exr")).status();
  EXPECT_EQ(missing.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.message()), HasSubstr("no.exr"));
  EXPECT_FALSE(ReadExr(folder.File("")).ok());
}

}  // namespace
}  // namespace shutterline
