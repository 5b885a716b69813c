// Removing jobs, through the coordinator's services.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/ids.h"
#include "common/base/log.h"
#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::server {
namespace {

using test::FakeWorker;
using testing::HasSubstr;
using testing::IsEmpty;
using Request = v1::ControlRequest;

class JobRemovalTest : public test::CoordinatorFixture {
 protected:
  /// Nothing is printed; jobs' own logs are written all the same.
  JobRemovalTest() { EXPECT_TRUE(SetUpLog("server", "off").ok()); }

  grpc::Status Remove(const std::string& job_id) {
    v1::Job job;
    return Control(job_id, Request::ACTION_REMOVE, job);
  }
  /// What was to be removed is gone after this: it may have had to wait for a frame's last steps.
  void Restart() {
    StopCoordinator();
    StartCoordinator();
    StopCoordinator();  // Ends what the start has begun.
    StartCoordinator();
  }
  /// Every file below the data folder whose path names the job.
  std::vector<std::string> FilesOf(const std::string& job_id) const {
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(config_.data_dir)) {
      if (entry.path().string().find(job_id) != std::string::npos) files.push_back(entry.path());
    }
    return files;
  }
};

TEST_F(JobRemovalTest, AJobThatHasEndedIsGoneWithItsFilesAndSaysSo) {
  const v1::SubmitRequest request = TriangleJob(1, 1, 64, 64);
  const v1::Job job = SubmitOrDie(request);
  EXPECT_EQ(Remove(job.id()).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(Remove(job.id()).error_message(), HasSubstr("has not ended: cancel it first"));
  {
    FakeWorker worker(channel_);
    worker.RenderUntilForgotten();
  }
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
  EXPECT_THAT(FilesOf(job.id()), testing::SizeIs(testing::Ge(3u)));  // Its frames' folder, a frame, a log.
  v1::Job answer;
  const grpc::Status removed = Control(job.id(), Request::ACTION_REMOVE, answer);
  ASSERT_TRUE(removed.ok()) << removed.error_message();
  EXPECT_EQ(answer.state(), v1::JOB_STATE_SUCCEEDED);
  EXPECT_EQ(answer.spec().name(), "triangle");
  for (int start = 0; start < 2; ++start) {
    v1::Job other;
    std::string bytes;
    v1::FrameChunk first;
    for (const grpc::Status& status :
         {Remove(job.id()), Control(job.id(), Request::ACTION_RETRY, other), Cancel(job.id(), other),
          Fetch(job.id(), 1, 0, bytes, first), Submit(request, other)}) {
      EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
      EXPECT_THAT(status.error_message(), HasSubstr("job " + job.id() + " was removed at 20"));
    }
    Restart();
  }
  EXPECT_THAT(FilesOf(job.id()), IsEmpty());
  EXPECT_EQ(Remove(MakeUuid()).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(Remove(MakeUuid()).error_message(), HasSubstr("there is no job"));
  EXPECT_THAT(Remove("../../etc").error_message(), HasSubstr("there is no job"));
}

TEST_F(JobRemovalTest, AJobThatBeganBecauseARemovedOneSucceededGoesOnAfterARestart) {
  const v1::Job before = SubmitOrDie(TriangleJob(0, 0, 32, 32));
  v1::SubmitRequest request = TriangleJob(0, 0, 32, 32);
  request.add_after(before.id());
  const v1::Job after = SubmitOrDie(request);
  {
    FakeWorker worker(channel_);
    worker.Credit(1);
    worker.Render(worker.NextGrant());
    EXPECT_EQ(WaitForEnd(before.id()).state(), v1::JOB_STATE_SUCCEEDED);
  }
  ASSERT_TRUE(Remove(before.id()).ok());
  EXPECT_EQ(Get(after.id()).waits_for_size(), 0);
  StopCoordinator();
  StartCoordinator();
  EXPECT_EQ(Get(after.id()).waits_for_size(), 0);
  EXPECT_THAT(Get(after.id()).after(), testing::ElementsAre(before.id()));
  FakeWorker worker(channel_);
  worker.RenderUntilForgotten();
  EXPECT_EQ(WaitForEnd(after.id()).state(), v1::JOB_STATE_SUCCEEDED);
  v1::Job refused;
  v1::SubmitRequest late = TriangleJob(0, 0, 32, 32);
  late.add_after(before.id());
  EXPECT_THAT(Submit(late, refused).error_message(), HasSubstr("was removed"));
}

TEST_F(JobRemovalTest, AJobThatWaitsInVainKeepsWaitingAfterTheOtherWentWithItsDependant) {
  const v1::Job failed = SubmitOrDie(TriangleJob(0, 0, 32, 32));
  v1::SubmitRequest request = TriangleJob(0, 0, 32, 32);
  request.add_after(failed.id());
  const v1::Job waits = SubmitOrDie(request);
  v1::Job job;
  ASSERT_TRUE(Cancel(failed.id(), job).ok());
  EXPECT_EQ(Remove(failed.id()).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(Remove(failed.id()).error_message(), HasSubstr("job " + waits.id() + " waits for job"));
  ASSERT_TRUE(Cancel(waits.id(), job).ok());
  ASSERT_TRUE(Remove(failed.id()).ok());
  // Tried again, it still waits for what will not come, and says so.
  EXPECT_THAT(ControlOrDie(waits.id(), Request::ACTION_RETRY).waits_for(), testing::ElementsAre(failed.id()));
  StopCoordinator();
  StartCoordinator();
  EXPECT_THAT(Get(waits.id()).waits_for(), testing::ElementsAre(failed.id()));
}

TEST_F(JobRemovalTest, TilesOfPartialFramesGoWithTheirJob) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 64, 32));
  {
    FakeWorker worker(channel_);
    worker.Credit(1);
    worker.Render(worker.NextGrant());
    for (int i = 0; i < 3; ++i) worker.FailNext("no");
    EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_PARTIAL);
  }
  StopCoordinator();
  const std::filesystem::path journal = config_.data_dir + "/journal";
  EXPECT_FALSE(std::filesystem::is_empty(journal));
  StartCoordinator();
  ASSERT_TRUE(Remove(job.id()).ok());
  Restart();
  EXPECT_TRUE(std::filesystem::is_empty(journal));
}

}  // namespace
}  // namespace shutterline::server
