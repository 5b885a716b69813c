#include "server/schedule/fair_share.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

namespace shutterline::server {
namespace {

using testing::ElementsAre;

TEST(FairShareTest, PriorityThenUserThenJobThenAge) {
  FairShare shares;
  shares.Add(1, 0, "ann");
  shares.Add(2, 0, "ann");
  shares.Add(3, 0, "bob");
  shares.Add(4, 7, "ann");
  EXPECT_THAT(shares.Rank({1, 2, 3, 4}, 0, 0), ElementsAre(4, 1, 2, 3));
  shares.Charge(1, 2);
  EXPECT_THAT(shares.Rank({1, 2, 3, 4}, 0, 0), ElementsAre(4, 3, 2, 1));
  shares.Charge(3, 3);
  EXPECT_THAT(shares.Rank({1, 2, 3, 4}, 0, 0), ElementsAre(4, 2, 1, 3));
  shares.SetPriority(3, 8);
  EXPECT_THAT(shares.Rank({3, 4}, 0, 0), ElementsAre(3, 4));
}

TEST(FairShareTest, JobAtHandStaysInFrontWithinTheSlackAlone) {
  FairShare shares;
  shares.Add(1, 0, "ann");
  shares.Add(2, 0, "bob");
  shares.Add(3, 1, "eve");
  shares.Charge(1, 2);
  EXPECT_THAT(shares.Rank({1, 2}, 1, 2), ElementsAre(1, 2));
  EXPECT_THAT(shares.Rank({1, 2}, 1, 1.5), ElementsAre(2, 1));
  EXPECT_THAT(shares.Rank({1, 2, 3}, 1, 100), ElementsAre(3, 2, 1));  // Never before a higher priority.
}

TEST(FairShareTest, WhoComesLateStartsLevelAndPaysNothingForNightsAlone) {
  FairShare shares;
  shares.Add(1, 0, "ann");
  shares.Rank({1}, 0, 0);
  shares.Charge(1, 1000);
  shares.Add(2, 0, "bob");
  EXPECT_THAT(shares.Rank({1, 2}, 0, 0), ElementsAre(1, 2));  // Level: the older first.
  shares.Charge(1, 1);
  EXPECT_THAT(shares.Rank({1, 2}, 0, 0), ElementsAre(2, 1));
  EXPECT_EQ(shares.UserSeconds("bob"), 1000);
  shares.Remove(2);
  EXPECT_EQ(shares.UserSeconds("bob"), 0);
}

/// Users with many jobs and few, each always hungry: nobody gets ahead by more than the slack and one lease.
TEST(FairShareTest, UsersAndTheirJobsGetEqualShares) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    FairShare shares;
    std::vector<JobKey> jobs;
    std::map<JobKey, std::string> user_of;
    const int users = 2 + int(random() % 4);
    for (int user = 0; user < users; ++user) {
      for (uint32_t i = 0; i <= random() % 5; ++i) {
        jobs.push_back(jobs.size() + 1);
        user_of[jobs.back()] = std::string(1, char('a' + user));
        shares.Add(jobs.back(), 0, user_of[jobs.back()]);
      }
    }
    const double slack = double(random() % 4), longest = 2;
    std::map<int, JobKey> current;
    for (int step = 0; step < 5000; ++step) {
      const int worker = int(random() % 8);
      current[worker] = shares.Rank(jobs, current[worker], slack).front();
      shares.Charge(current[worker], longest * double(random() % 1000 + 1) / 1000);
      for (const JobKey a : jobs) {
        for (const JobKey b : jobs) {
          if (user_of[a] == user_of[b]) {
            ASSERT_LE(shares.JobSeconds(a) - shares.JobSeconds(b), slack + longest);
          } else {
            ASSERT_LE(shares.UserSeconds(user_of[a]) - shares.UserSeconds(user_of[b]), slack + longest);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace shutterline::server
