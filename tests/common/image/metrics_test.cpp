#include "common/image/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/common/image/random_image.h"

namespace shutterline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string MessageOf(const absl::Status& status) {
  return std::string(status.message());
}

TEST(Compare, EqualPictures) {
  const Image image = RandomImage(9, 8, 1);
  const auto result = Compare(image, image);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->rmse, 0);
  EXPECT_EQ(result->psnr, std::numeric_limits<double>::infinity());
  EXPECT_EQ(result->relative_mse, 0);
  EXPECT_EQ(result->largest_difference, 0);
}

TEST(Compare, ConstantOffsetHasAClosedForm) {
  Image reference(13, 7), test(13, 7);
  for (float& value : reference.values()) value = 0.5f;
  for (float& value : test.values()) value = 0.75f;
  const auto result = Compare(test, reference);
  ASSERT_TRUE(result.ok());
  EXPECT_DOUBLE_EQ(result->rmse, 0.25);
  EXPECT_DOUBLE_EQ(result->psnr, -20 * std::log10(0.25));
  EXPECT_DOUBLE_EQ(result->relative_mse, 0.25 * 0.25 / (0.51 * 0.51));
}

TEST(Compare, OnePixelInOneChannel) {
  const Image reference(10, 10);
  Image test = reference;
  test.At(3, 8)[1] = 0.3f;
  const auto result = Compare(test, reference);
  ASSERT_TRUE(result.ok());
  const double d = double(0.3f);
  EXPECT_DOUBLE_EQ(result->rmse, std::sqrt(d * d / 300));
  EXPECT_DOUBLE_EQ(result->relative_mse, d * d / 1e-4 / 300);
  EXPECT_EQ(result->largest_difference, d);
  EXPECT_EQ(result->largest_x, 3);
  EXPECT_EQ(result->largest_y, 8);
  EXPECT_EQ(result->largest_channel, "G");
}

TEST(Compare, AlphaCountsInTheLargestDifferenceOnly) {
  const Image reference(4, 4);
  Image test = reference;
  test.At(2, 1)[3] = -1;
  const auto result = Compare(test, reference);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->rmse, 0);
  EXPECT_EQ(result->largest_difference, 1);
  EXPECT_EQ(result->largest_channel, "A");
}

TEST(Compare, SumsDoNotLoseSmallErrors) {
  // One squared error of 1e16 and 3 · 2^16 − 1 of 1: plain doubles would drop half of the ones.
  Image reference(256, 256), test(256, 256);
  for (float& value : test.values()) value = 1;
  test.At(0, 0)[0] = 1e8f;
  const auto result = Compare(test, reference);
  ASSERT_TRUE(result.ok());
  EXPECT_DOUBLE_EQ(result->rmse, std::sqrt((1e16 + 3 * 65536 - 1) / (3 * 65536)));
}

TEST(Compare, RefusesOtherShapesByName) {
  const auto sizes = Compare(Image(4, 5), Image(5, 4));
  EXPECT_EQ(sizes.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(MessageOf(sizes.status()), AllOf(HasSubstr("4 × 5"), HasSubstr("5 × 4")));
  const auto channels = Compare(Image(4, 5, {"R", "G", "B"}), Image(4, 5));
  EXPECT_THAT(MessageOf(channels.status()), AllOf(HasSubstr("R,G,B,"), HasSubstr("R,G,B,A")));
  EXPECT_THAT(MessageOf(Compare(Image(2, 2, {"Z"}), Image(2, 2, {"Z"})).status()), HasSubstr("no channel R"));
  EXPECT_FALSE(Compare(Image(0, 0), Image(0, 0)).ok());
}

TEST(Compare, NamesThePixelThatIsNotFinite) {
  const Image reference(6, 6);
  Image test(6, 6);
  test.At(4, 2)[2] = std::nanf("");
  EXPECT_THAT(MessageOf(Compare(test, reference).status()),
              AllOf(HasSubstr("NaN"), HasSubstr("(4, 2)"), HasSubstr("channel B"), HasSubstr("the picture")));
  EXPECT_THAT(MessageOf(Compare(reference, test).status()), HasSubstr("the reference"));
  test.At(4, 2)[2] = -std::numeric_limits<float>::infinity();
  EXPECT_THAT(MessageOf(Compare(test, reference).status()), HasSubstr("infinite"));
}

/// truth + noise of standard deviation `sigma`.
Image Noisy(const Image& truth, double sigma, std::mt19937& random) {
  std::normal_distribution<double> normal(0, sigma);
  Image result = truth;
  for (float& value : result.values()) value = float(value + normal(random));
  return result;
}

/// The mean of D over many pairs of references is the true error, far below the references' own noise,
/// and the naive error is not.
TEST(UnbiasedError, CancelsTheReferencesNoise) {
  const uint32_t seed = 4711;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  const Image truth = RandomImage(48, 48, seed);
  Image test = truth;
  for (float& value : test.values()) value += 0.01f;
  const double true_error = 1e-4, sigma = 0.05;
  const int trials = 40;
  double mean = 0, covered = 0, naive = 0, error_of_mean = 0;
  for (int i = 0; i < trials; ++i) {
    const Image a = Noisy(truth, sigma, random), b = Noisy(truth, sigma, random);
    const auto result = MeasureUnbiasedError(test, a, b);
    ASSERT_TRUE(result.ok());
    mean += result->d / trials;
    error_of_mean += result->standard_error * result->standard_error / trials / trials;
    covered += std::abs(result->d - true_error) <= 2 * result->standard_error ? 1 : 0;
    naive += std::pow(Compare(test, a)->rmse, 2) / trials;
  }
  EXPECT_NEAR(mean, true_error, 4 * std::sqrt(error_of_mean));
  EXPECT_LT(std::sqrt(error_of_mean), 0.1 * true_error);  // The line above says something.
  EXPECT_GT(naive, 10 * true_error);
  EXPECT_GE(covered, 0.8 * trials);  // 95 % expected.
}

TEST(UnbiasedError, SaysWhenBelowTheFloor) {
  Image test(2, 2), a(2, 2), b(2, 2);
  for (size_t i = 0; i < test.values().size(); ++i) {
    a.values()[i] = 0.1f;
    b.values()[i] = -0.1f;
  }
  const auto result = MeasureUnbiasedError(test, a, b);
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(result->d, -0.01, 1e-8);
  EXPECT_TRUE(result->BelowFloor());
  EXPECT_EQ(result->Rmse(), 0);
  EXPECT_THAT(result->ToString(), HasSubstr("below the reference's floor"));
}

TEST(UnbiasedError, MaskChoosesPixels) {
  Image test(3, 1);
  const Image zero(3, 1);
  test.At(1, 0)[0] = 3;
  test.At(2, 0)[0] = 6;
  const std::vector<uint8_t> mask = {1, 255, 0};
  const auto result = MeasureUnbiasedError(test, zero, zero, mask);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->pixels, 2);
  EXPECT_DOUBLE_EQ(result->d, 1.5);               // Products 0 and 9 / 3.
  EXPECT_DOUBLE_EQ(result->standard_error, 1.5);  // Their deviation is 3 / sqrt 2, over sqrt 2.
  EXPECT_FALSE(MeasureUnbiasedError(test, zero, zero, std::vector<uint8_t>{1, 1}).ok());
  EXPECT_FALSE(MeasureUnbiasedError(test, zero, zero, std::vector<uint8_t>{0, 0, 0}).ok());
  EXPECT_FALSE(MeasureUnbiasedError(test, zero, Image(1, 3)).ok());
}

}  // namespace
}  // namespace shutterline
