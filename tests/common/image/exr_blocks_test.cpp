#include "common/image/exr_blocks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <random>
#include <thread>
#include <tuple>

#include "common/job/tile.h"
#include "tests/common/image/random_image.h"

namespace shutterline {
namespace {

using testing::HasSubstr;

std::string PixelsOf(const Image& image, const TileRect& rect) {
  std::string pixels;
  for (int y = 0; y < rect.height; ++y) {
    pixels.append(reinterpret_cast<const char*>(image.At(rect.x, rect.y + y)),
                  size_t(rect.width) * size_t(image.channel_count()) * sizeof(float));
  }
  return pixels;
}

using Case = std::tuple<PixelType, ExrCompression, std::pair<int, int>>;
class BlocksOfAPicture : public testing::TestWithParam<Case> {};

TEST_P(BlocksOfAPicture, AreTheFileThatTheLibraryWritesWhateverTheirOrder) {
  const auto [type, compression, size] = GetParam();
  std::vector<std::string> channels = {"R", "G", "B", "A", "Z", "object-id"};
  // Smooth on the left, noise on the right: some blocks are smaller than their pixels, and some are not.
  Image image = RandomImage(size.first, size.second, 11, -2, 70000, channels);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width() / 2; ++x) {
      for (int c = 0; c < image.channel_count(); ++c) image.At(x, y)[c] = float(x / 7 + c);
    }
  }
  const std::vector<std::string> exact = {"Z", "object-id"};
  const OutputSettings output{type, compression};
  ExrMetadata metadata;
  metadata.frames_per_second = FrameRateOf(24);
  metadata.world_to_camera = M44d();
  metadata.strings["shutterline:a name of more than thirty-one bytes"] = std::string(3000, 'x');
  const auto whole = EncodeExr(image, output, metadata, exact);
  ASSERT_TRUE(whole.ok()) << whole.status();

  const TileGrid grid{image.width(), image.height()};
  const ExrBlockEncoder encoder(channels, output, exact);
  std::vector<int> order(size_t(grid.Count()));
  for (size_t i = 0; i < order.size(); ++i) order[i] = int(i);
  for (uint32_t seed = 1; seed <= 3; ++seed) {
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    std::vector<std::string> blocks(order.size());
    std::atomic<size_t> next = 0;
    const auto work = [&] {
      for (size_t i = next++; i < order.size(); i = next++) {
        const TileRect rect = grid.Rect(order[i]);
        auto block = encoder.Encode(rect.width, rect.height, PixelsOf(image, rect));
        if (block.ok()) blocks[size_t(order[i])] = *std::move(block);
      }
    };
    std::thread other(work);
    work();
    other.join();
    const auto joined = encoder.Join(image.width(), image.height(), blocks, metadata);
    ASSERT_TRUE(joined.ok()) << joined.status();
    EXPECT_TRUE(*joined == *whole) << "seed " << seed << ": " << joined->size() << " bytes, not "
                                   << whole->size();
  }
}

INSTANTIATE_TEST_SUITE_P(All, BlocksOfAPicture,
                         testing::Combine(testing::Values(PixelType::kHalf, PixelType::kFloat),
                                          testing::Values(ExrCompression::kNone, ExrCompression::kZip,
                                                          ExrCompression::kPiz, ExrCompression::kDwaa),
                                          testing::Values(std::pair(1, 1), std::pair(32, 32),
                                                          std::pair(163, 71), std::pair(64, 97),
                                                          std::pair(3000, 2))));

TEST(ExrBlocks, AreRefusedWhereTheyAreOfAnotherPicture) {
  const ExrBlockEncoder encoder({"R", "G"}, {});
  const std::string pixels(32 * 32 * 2 * sizeof(float), '\0');
  EXPECT_TRUE(encoder.Encode(32, 32, pixels).ok());
  EXPECT_EQ(encoder.Encode(32, 31, pixels).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(encoder.Encode(64, 16, pixels).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(encoder.Encode(0, 32, "").status().code(), absl::StatusCode::kInvalidArgument);
  const std::vector<std::string> three(3);
  EXPECT_THAT(std::string(encoder.Join(64, 64, three, {}).status().message()),
              HasSubstr("3 blocks for 4 tiles"));
  EXPECT_EQ(encoder.Join(0, 64, {}, {}).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ExrBlockEncoder({"R", "R"}, {}).Encode(32, 32, pixels).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ExrBlockEncoder({}, {}).Encode(32, 32, "").status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(ExrBlocks, MetadataIsJudgedAsThatOfAWholePicture) {
  ExrMetadata metadata;
  metadata.strings["compression"] = "none at all";
  const ExrBlockEncoder encoder({"R"}, {});
  const std::vector<std::string> one(1);
  const auto joined = encoder.Join(1, 1, one, metadata);
  EXPECT_EQ(joined.status(), EncodeExr(Image(1, 1, {"R"}), {}, metadata).status());
  EXPECT_EQ(joined.status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace shutterline
