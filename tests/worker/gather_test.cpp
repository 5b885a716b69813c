#include "worker/loop/gather.h"

#include <gtest/gtest.h>

#include "worker/loop/credit.h"

namespace shutterline::worker {
namespace {

constexpr size_t kEnough = 1000;
constexpr absl::Duration kStart = absl::Seconds(5000);

TEST(GatherTest, TheFirstResultSaysWhenAllAreSent) {
  Gather gather;
  gather.SetPace(absl::Milliseconds(300));
  EXPECT_EQ(gather.Due(kEnough), absl::InfiniteDuration()) << "nothing waits";
  gather.Add(10, kStart);
  gather.Add(10, kStart + absl::Milliseconds(200));
  EXPECT_EQ(gather.Due(kEnough), kStart + absl::Milliseconds(300));
  gather.Remove(10);
  gather.Remove(10);
  EXPECT_EQ(gather.Due(kEnough), absl::InfiniteDuration());
  gather.Add(10, kStart + absl::Seconds(9));
  EXPECT_EQ(gather.Due(kEnough), kStart + absl::Seconds(9) + absl::Milliseconds(300));
}

TEST(GatherTest, ANewPaceHoldsForWhatWaitsAlready) {
  Gather gather;
  gather.SetPace(absl::Milliseconds(300));
  gather.Add(10, kStart);
  gather.SetPace(absl::Milliseconds(5));
  EXPECT_EQ(gather.Due(kEnough), kStart + absl::Milliseconds(5));
}

TEST(GatherTest, EnoughResultsOrBytesAndHurryWaitForNothing) {
  Gather gather;
  gather.SetPace(absl::Seconds(1));
  for (size_t i = 1; i < Gather::kEnoughResults; ++i) gather.Add(1, kStart);
  EXPECT_GT(gather.Due(kEnough), kStart);
  gather.Add(1, kStart);
  EXPECT_LT(gather.Due(kEnough), kStart);
  gather.Remove(1);
  EXPECT_GT(gather.Due(kEnough), kStart);
  gather.Add(kEnough, kStart);
  EXPECT_LT(gather.Due(kEnough), kStart);
  gather.Remove(kEnough);
  gather.Hurry();
  EXPECT_LT(gather.Due(kEnough), kStart);
}

TEST(GatherTest, HurryIsOverWhenAllIsSentAndDoesNotHoldForWhatComesLater) {
  Gather gather;
  gather.SetPace(absl::Seconds(1));
  EXPECT_FALSE(gather.Hurry());
  gather.Add(10, kStart);
  EXPECT_GT(gather.Due(kEnough), kStart) << "nothing waited when it was said";
  gather.Add(10, kStart);
  EXPECT_TRUE(gather.Hurry());
  gather.Remove(10);
  EXPECT_LT(gather.Due(kEnough), kStart) << "what did not fit into the message is late as well";
  gather.Remove(10);
  gather.Add(10, kStart);
  EXPECT_GT(gather.Due(kEnough), kStart);
}

TEST(GatherTest, PacesThatMakeNoSenseAreBroughtIntoBounds) {
  Gather gather;
  gather.SetPace(absl::InfiniteDuration());
  EXPECT_EQ(gather.pace(), Gather::kLongest);
  gather.SetPace(absl::Hours(24 * 365 * 10'000));
  EXPECT_EQ(gather.pace(), Gather::kLongest);
  gather.SetPace(-absl::InfiniteDuration());
  EXPECT_EQ(gather.pace(), absl::ZeroDuration());
}

TEST(CreditTest, ThreeLeasesASlotAreKeptAndAskedForBelowTwoOrWithResults) {
  EXPECT_EQ(LeasesToAskFor(0, 2, 0, false), 6u);
  EXPECT_EQ(LeasesToAskFor(3, 2, 0, false), 3u);
  EXPECT_EQ(LeasesToAskFor(4, 2, 0, false), 0u);
  EXPECT_EQ(LeasesToAskFor(4, 2, 0, true), 2u);
  EXPECT_EQ(LeasesToAskFor(6, 2, 0, true), 0u);
  EXPECT_EQ(LeasesToAskFor(9, 2, 16, false), 13u);
  EXPECT_EQ(LeasesToAskFor(7, 2, 0, true), 0u) << "more than ever were asked for";
  EXPECT_TRUE(MayGoWithResults(2, 2));
  EXPECT_FALSE(MayGoWithResults(1, 2)) << "a thread has nothing to do";
}

}  // namespace
}  // namespace shutterline::worker
