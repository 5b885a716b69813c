#include "server/logs/job_logs.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <thread>

#include "common/base/ids.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::server {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class JobLogsTest : public testing::Test {
 protected:
  JobLogsTest() {
    EXPECT_TRUE(SetUpLog("test", "off").ok());  // Nothing is printed; the logs hear all the same.
    Open({});
  }
  void Open(const JobLogs::Options& options) {
    logs_.reset();
    auto logs = JobLogs::Open(folder_.path() + "/logs", options);
    ASSERT_TRUE(logs.ok()) << logs.status();
    logs_ = *std::move(logs);
  }
  std::string Read(const std::string& job) {
    const auto text = logs_->Read(job, 0, 1 << 20);
    EXPECT_TRUE(text.ok()) << text.status();
    return text.ok() ? *text : "";
  }

  test::TemporaryFolder folder_;
  std::unique_ptr<JobLogs> logs_;
  const std::string a_ = MakeUuid(), b_ = MakeUuid();
};

TEST_F(JobLogsTest, EachJobHasTheLinesThatNameIt) {
  spdlog::info("job accepted job={} frames=2", a_);
  spdlog::warn("tile failed job={} tile=3", b_);
  spdlog::info("worker registered worker=x");
  spdlog::debug("a detail job={}", a_);
  EXPECT_THAT(Read(a_),
              AllOf(HasSubstr(" info  test: job accepted job="), HasSubstr("frames=2\n"),
                    Not(HasSubstr("tile failed")), Not(HasSubstr("detail")), Not(HasSubstr("worker"))));
  EXPECT_THAT(Read(b_), HasSubstr("tile failed"));
  EXPECT_EQ(Read(MakeUuid()), "");
}

TEST_F(JobLogsTest, StrangersCannotWriteIntoAnotherJobsLogNorNameFiles) {
  spdlog::info("job accepted name={} job={}", LogValue(absl::StrCat("x job=", b_)), a_);
  spdlog::info("job accepted name={} job={}", LogValue(absl::StrCat("x\" job=", b_)), a_);
  spdlog::info("job accepted name={} job={}", LogValue(absl::StrCat("x\\\" job=", b_, " \\")), a_);
  EXPECT_EQ(Read(b_), "");
  const std::string own = Read(a_);
  EXPECT_EQ(std::count(own.begin(), own.end(), '\n'), 3);
  spdlog::info("odd job=../../../../tmp/x");
  spdlog::info("short job=");
  EXPECT_EQ(logs_->Read("../logs/x", 0, 10).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(JobLogsTest, GoesOnAfterARestartAndReadsFromAnOffset) {
  spdlog::info("one job={}", a_);
  const size_t first = Read(a_).size();
  Open({});
  spdlog::info("two job={}", a_);
  EXPECT_THAT(Read(a_), AllOf(HasSubstr("one"), HasSubstr("two")));
  EXPECT_THAT(*logs_->Read(a_, first, 1000), AllOf(HasSubstr("two"), Not(HasSubstr("one"))));
  EXPECT_EQ(*logs_->Read(a_, 1 << 30, 1000), "");
}

TEST_F(JobLogsTest, StopsWhenFullAndSaysSoOnceAlsoAfterARestart) {
  JobLogs::Options small;
  small.max_bytes = 1000;
  Open(small);
  for (int i = 0; i < 100; ++i) spdlog::info("line {} job={}", i, a_);
  const std::string full = Read(a_);
  EXPECT_THAT(full, EndsWith("is full: what follows is in the coordinator's alone.\n"));
  EXPECT_LT(full.size(), 1300u);
  Open(small);
  spdlog::info("more job={}", a_);
  EXPECT_EQ(Read(a_), full);
  spdlog::info("another's job={}", b_);
  EXPECT_THAT(Read(b_), HasSubstr("another's"));
}

TEST_F(JobLogsTest, ManyThreadsAndMoreJobsThanOpenFilesLoseNoLine) {
  JobLogs::Options two;
  two.max_open_files = 2;
  Open(two);
  std::vector<std::string> jobs(6);
  for (std::string& job : jobs) job = MakeUuid();
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&jobs, t] {
      for (int i = 0; i < 60; ++i)
        spdlog::info("thread={} line={} job={}", t, i, jobs[size_t(i) % jobs.size()]);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& job : jobs) {
    const std::string text = Read(job);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 40);
  }
}

TEST_F(JobLogsTest, LinesThatTheDiskRefusesAreCounted) {
  ASSERT_EQ(std::system(absl::StrCat("mkdir ", folder_.path(), "/logs/", a_, ".log").c_str()), 0);
  spdlog::info("lost job={}", a_);
  spdlog::info("lost too job={}", a_);
  spdlog::info("kept job={}", b_);
  EXPECT_THAT(Read(b_), AllOf(StartsWith("The disk refused 2 lines"), HasSubstr("kept")));
}

}  // namespace
}  // namespace shutterline::server
