// Jobs that have ended go when they are old enough, or too many, by a clock that the test holds.
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/crash_workload.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class JobRetentionTest : public testing::Test {
 protected:
  void Open(absl::Duration keep, int64_t keep_max) {
    workload_.config().keep_jobs = keep;
    workload_.config().keep_jobs_max = keep_max;
    ASSERT_TRUE(workload_.Open().ok());
    Acknowledged acknowledged{};
    ASSERT_TRUE(workload_.Submit(acknowledged).ok());  // For its blob.
    ASSERT_TRUE(workload_.farm().Cancel(Ids().front()).ok());
  }
  server::Farm& farm() { return workload_.farm(); }

  std::string Submit(const std::string& after = "") {
    server::JobWishes wishes;
    if (!after.empty()) wishes.after = {after};
    const auto job = farm().Submit(absl::StrCat("request ", ++requests_), CrashWorkload::Spec(), wishes);
    EXPECT_TRUE(job.ok()) << job.status();
    return job.ok() ? job->id : "";
  }
  /// A job that ends now, cancelled.
  std::string Ended() {
    const std::string id = Submit();
    EXPECT_TRUE(farm().Cancel(id).ok());
    return id;
  }
  void Pass(absl::Duration time) {
    workload_.clock().Advance(time);
    farm().Tick();
    workload_.WaitForFrames();
  }
  /// Of all jobs, oldest first.
  std::vector<std::string> Ids() {
    const auto jobs = farm().List(UINT64_MAX, 1000);
    EXPECT_TRUE(jobs.ok()) << jobs.status();
    std::vector<std::string> ids;
    if (!jobs.ok()) return ids;
    for (const server::JobSnapshot& job : *jobs) ids.insert(ids.begin(), job.id);
    return ids;
  }

  TemporaryFolder folder_;
  CrashWorkload workload_{folder_.path() + "/data", server::Durability::kProcess};
  int requests_ = 0;
};

TEST_F(JobRetentionTest, WithoutOptionsNothingEverGoes) {
  Open(absl::InfiniteDuration(), 0);
  Pass(absl::Hours(1'000'000));
  EXPECT_EQ(Ids().size(), 1u);
}

TEST_F(JobRetentionTest, AJobGoesAsLongAfterItsEndAsItIsKept) {
  Open(absl::Hours(10), 0);
  const std::string lives = Submit();
  Pass(absl::Hours(2));
  const std::string second = Ended();
  Pass(absl::Hours(7));
  EXPECT_EQ(Ids().size(), 3u);
  Pass(absl::Hours(1));  // Ten hours and some half minutes after the first one's end.
  EXPECT_THAT(Ids(), ElementsAre(lives, second));
  Pass(absl::Hours(3));
  EXPECT_THAT(Ids(), ElementsAre(lives));
  EXPECT_THAT(std::string(farm().Get(second).status().message()),
              HasSubstr(absl::StrCat("job ", second, " was removed at ")));
  EXPECT_EQ(workload_.LeftOver(), "");
  // The next coordinator knows what it was, and goes on removing.
  ASSERT_TRUE(farm().Cancel(lives).ok());
  ASSERT_TRUE(workload_.Open().ok());
  EXPECT_TRUE(absl::IsNotFound(farm().Get(second).status()));
  Pass(absl::Hours(11));
  EXPECT_THAT(Ids(), IsEmpty());
}

TEST_F(JobRetentionTest, OfTooManyThoseGoThatEndedFirst) {
  Open(absl::InfiniteDuration(), 2);
  std::vector<std::string> ids = Ids();
  const std::string lives = Submit();
  for (int i = 0; i < 600; ++i) {
    workload_.clock().Advance(absl::Milliseconds(1));
    ids.push_back(Ended());
  }
  Pass(absl::Minutes(1));
  EXPECT_THAT(Ids(), ElementsAre(lives, ids[599], ids[600]));
  // A retry takes a job out of their number, until it has ended again.
  ASSERT_TRUE(farm().Retry(ids[599]).ok());
  const std::string last = Ended();
  Pass(absl::Minutes(1));
  EXPECT_THAT(Ids(), ElementsAre(lives, ids[599], ids[600], last));
  ASSERT_TRUE(farm().Cancel(ids[599]).ok());
  Pass(absl::Minutes(1));
  EXPECT_THAT(Ids(), ElementsAre(lives, ids[599], last));
}

TEST_F(JobRetentionTest, WhatAnotherJobWaitsForStays) {
  Open(absl::Hours(1), 1);
  const std::string before = Ended(), waits = Submit(before);
  Pass(absl::Hours(5));
  EXPECT_THAT(Ids(), ElementsAre(before, waits));
  EXPECT_TRUE(absl::IsFailedPrecondition(farm().Remove(before).status()));
  ASSERT_TRUE(workload_.Open().ok());
  EXPECT_THAT(farm().Get(waits)->waits_for, ElementsAre(before));
  ASSERT_TRUE(farm().Cancel(waits).ok());
  Pass(absl::Minutes(1));
  EXPECT_THAT(Ids(), ElementsAre(waits));
}

/// Counts what it hears.
class Watcher final : public server::JobWatcher {
 public:
  void OnChange() override { ++heard; }
  int heard = 0;
};

TEST_F(JobRetentionTest, WhoIsStillBeingToldOfTheEndIsTold) {
  Open(absl::Hours(1), 0);
  const std::string id = Ids().front();
  Watcher watcher;
  ASSERT_TRUE(farm().AddWatcher(id, &watcher).ok());
  Pass(absl::Hours(5));
  EXPECT_THAT(Ids(), ElementsAre(id));
  farm().RemoveWatcher(id, &watcher);
  Pass(absl::Minutes(1));
  EXPECT_THAT(Ids(), IsEmpty());
  EXPECT_TRUE(absl::IsNotFound(farm().AddWatcher(id, &watcher)));
  // By hand it goes at once, and the watch is over.
  const std::string other = Ended();
  ASSERT_TRUE(farm().AddWatcher(other, &watcher).ok());
  const int before = watcher.heard;
  ASSERT_TRUE(farm().Remove(other).ok());
  EXPECT_GT(watcher.heard, before);
  bool ended = false;
  EXPECT_EQ(farm().NextChange(other, 0, ended), std::nullopt);
  EXPECT_TRUE(ended);
  farm().RemoveWatcher(other, &watcher);
}

}  // namespace
}  // namespace shutterline::test
