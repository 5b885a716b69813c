#include "worker/engine/scene/environment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "common/image/exr.h"
#include "worker/engine/scene/memory_asset_source.h"

namespace shutterline::engine::environment_test {
namespace {

using testing::HasSubstr;

std::string Exr(const Image& image) {
  OutputSettings output;
  output.pixel_type = PixelType::kFloat;
  return *EncodeExr(image, output, {});
}

absl::StatusOr<std::shared_ptr<const Environment>> Read(const std::string& bytes) {
  return ReadEnvironment(MemoryAssetSource("a.gltf", {{std::string(kEnvironmentFile), bytes}}), 1 << 20);
}

TEST(Environment, IsNotThereUnlessTheSourceHasOne) {
  const auto environment = ReadEnvironment(MemoryAssetSource("a.gltf", {}), 1 << 20);
  ASSERT_TRUE(environment.ok()) << environment.status();
  EXPECT_EQ(*environment, nullptr);
}

TEST(Environment, ChannelsAreReadAndNegativesAreNothing) {
  Image image(4, 2, {"R", "G", "B"});
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; ++x) {
      image.At(x, y)[0] = float(x);
      image.At(x, y)[1] = float(y);
      image.At(x, y)[2] = x == 3 ? -1 : 0.5f;
    }
  }
  const auto environment = Read(Exr(image));
  ASSERT_TRUE(environment.ok()) << environment.status();
  EXPECT_EQ((*environment)->width, 4);
  EXPECT_EQ((*environment)->texels[6], V3f(2, 1, 0.5f));
  EXPECT_EQ((*environment)->texels[7], V3f(3, 1, 0));
  const auto gray = Read(Exr(Image(4, 2, {"Y"})));
  EXPECT_TRUE(gray.ok()) << gray.status();
}

TEST(Environment, WhatIsWrongIsNamed) {
  const auto expect = [](const std::string& bytes, const std::string& reason) {
    const absl::Status status = Read(bytes).status();
    EXPECT_FALSE(status.ok()) << reason;
    EXPECT_THAT(std::string(status.message()), HasSubstr("environment"));
    EXPECT_THAT(std::string(status.message()), HasSubstr(reason));
  };
  expect("no picture", "EXR");
  expect(Exr(Image(4, 4, {"R", "G", "B"})), "twice as wide as high");
  expect(Exr(Image(4, 2, {"R", "G"})), "neither channels");
  Image bad(4, 2, {"R", "G", "B"});
  bad.At(2, 1)[1] = std::numeric_limits<float>::quiet_NaN();
  expect(Exr(bad), "pixel (2, 1), channel G");
  const std::string whole = Exr(Image(64, 32, {"R", "G", "B"}));
  for (size_t cut = 0; cut < whole.size(); cut += 97) EXPECT_FALSE(Read(whole.substr(0, cut)).ok()) << cut;
}

}  // namespace
}  // namespace shutterline::engine::environment_test
