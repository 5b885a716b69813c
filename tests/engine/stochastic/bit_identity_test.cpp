// Pictures are equal to the last bit whatever cuts, schedules or computes them.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "tests/engine/stochastic/stochastic_test_util.h"

namespace shutterline::engine::bit_identity_test {
namespace {

constexpr int kSide = 72;  // Neither cells nor blocks divide it into equal parts.

int64_t Differing(const Image& a, const Image& b) {
  int64_t count = 0;
  for (size_t i = 0; i < a.values().size(); ++i) count += a.values()[i] != b.values()[i];
  return count;
}

double Alpha(const Image& image) {
  double sum = 0;
  for (size_t i = 3; i < image.values().size(); i += 4) sum += double(image.values()[i]);
  return sum;
}

class BitIdentity : public testing::TestWithParam<int> {};

TEST_P(BitIdentity, TileSizesDoNotMatter) {
  const int spp = GetParam();
  for (const bool perspective : {true, false}) {
    const auto frame = RandomFrame(7, 60, kSide, perspective);
    const auto integrator = MakeStochastic(frame, spp);
    const Image whole = RenderTiles(*integrator, kSide, kSide, kSide, kSide);
    EXPECT_GT(Alpha(whole), 100);
    EXPECT_EQ(Differing(whole, RenderTiles(*integrator, kSide, kSide, 32, 32)), 0);
    EXPECT_EQ(Differing(whole, RenderTiles(*integrator, kSide, kSide, 7, 5)), 0);
    EXPECT_EQ(Differing(whole, RenderTiles(*integrator, kSide, kSide, 1, 64)), 0);
  }
}

TEST_P(BitIdentity, ThreadsDoNotMatter) {
  const auto frame = RandomFrame(8, 60, kSide);
  const auto integrator = MakeStochastic(frame, GetParam());
  EXPECT_EQ(Differing(RenderTiles(*integrator, kSide, kSide, 16, 16, 1),
                      RenderTiles(*integrator, kSide, kSide, 16, 16, 4)),
            0);
}

TEST_P(BitIdentity, InstructionSetsDoNotMatter) {
  const int spp = GetParam();
  for (const uint32_t seed : {1u, 2u}) {
    const auto frame = RandomFrame(seed, 60, kSide, seed == 1);
    const auto integrator = MakeStochastic(frame, spp);
    const int64_t all = hwy::SupportedTargets();
    ASSERT_NE(all, 0);
    Image first;
    for (int64_t left = all; left != 0; left &= left - 1) {
      const int64_t target = left & -left;
      if (target != HWY_AVX3 && target != HWY_AVX2 && target != HWY_STATIC_TARGET) continue;
      hwy::SetSupportedTargetsForTest(target);
      const Image image = RenderTiles(*integrator, kSide, kSide);
      if (first.values().empty()) {
        first = image;
      } else {
        EXPECT_EQ(Differing(first, image), 0) << hwy::TargetName(target) << ", seed " << seed;
      }
    }
    hwy::SetSupportedTargetsForTest(0);
    EXPECT_EQ(Differing(first, RenderTiles(*integrator, kSide, kSide)), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Spp, BitIdentity, testing::Values(1, 3, 16, 50, 256));

TEST(StochasticIntegrator, SeedsAndFramesDiffer) {
  const auto frame = RandomFrame(9, 60, kSide);
  const Image image = RenderTiles(*MakeStochastic(frame, 4), kSide, kSide);
  EXPECT_GT(Differing(image, RenderTiles(*MakeStochastic(frame, 4, 1), kSide, kSide)), 100);
  EXPECT_GT(Differing(image, RenderTiles(*MakeStochastic(frame, 4, 0, 1), kSide, kSide)), 100);
}

}  // namespace
}  // namespace shutterline::engine::bit_identity_test
