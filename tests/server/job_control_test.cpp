// Pausing, priorities, dependencies and retries, through the coordinator's services.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/ids.h"
#include "server/schedule/tile_order.h"
#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::server {
namespace {

using test::FakeWorker;
using testing::ElementsAre;
using testing::HasSubstr;
using Request = v1::ControlRequest;

class JobControlTest : public test::CoordinatorFixture {};

TEST_F(JobControlTest, PauseRevokesLeasesOutlivesARestartAndWhatComesAllTheSameCounts) {
  const v1::Job paused = SubmitOrDie(TriangleJob(0, 0, 64, 64));
  {
    FakeWorker worker(channel_);
    worker.Credit(1);
    const v1::Grant grant = worker.NextGrant();
    const v1::Job answer = ControlOrDie(paused.id(), Request::ACTION_PAUSE);
    EXPECT_TRUE(answer.paused());
    EXPECT_EQ(answer.state(), v1::JOB_STATE_QUEUED);
    v1::CoordinatorMessage message;
    ASSERT_TRUE(worker.Next(message));
    EXPECT_THAT(message.revoke().lease_ids(), ElementsAre(grant.lease_id()));
    EXPECT_THAT(worker.Render(grant).outcomes(), testing::Each(v1::ResultAck::OUTCOME_STORED));
    // The older job is passed over.
    const v1::Job other = SubmitOrDie(TriangleJob(0, 0, 32, 32));
    worker.Credit(2);
    EXPECT_EQ(worker.NextGrant().job_id(), other.id());
    EXPECT_TRUE(ControlOrDie(paused.id(), Request::ACTION_PAUSE).paused());  // Again: nothing changes.
  }
  StopCoordinator();
  StartCoordinator();
  EXPECT_TRUE(Get(paused.id()).paused());
  EXPECT_EQ(Get(paused.id()).tiles_done(), 1u);
  EXPECT_FALSE(ControlOrDie(paused.id(), Request::ACTION_RESUME).paused());
  FakeWorker worker(channel_);
  worker.RenderUntilForgotten();
  worker.RenderUntilForgotten();
  EXPECT_EQ(WaitForEnd(paused.id()).state(), v1::JOB_STATE_SUCCEEDED);
  ExpectSyntheticFrame(paused.id(), 0, 64, 64);
  EXPECT_FALSE(ControlOrDie(paused.id(), Request::ACTION_PAUSE).paused());  // It has ended.
}

TEST_F(JobControlTest, HigherPriorityIsServedFirstAndMayChange) {
  const v1::Job first = SubmitOrDie(TriangleJob(0, 0, 64, 64));
  v1::SubmitRequest urgent = TriangleJob(0, 0, 64, 64);
  urgent.set_priority(5);
  urgent.set_user("ann");
  const v1::Job second = SubmitOrDie(urgent);
  EXPECT_EQ(second.priority(), 5);
  EXPECT_EQ(second.user(), "ann");
  FakeWorker worker(channel_);
  worker.Credit(1);
  EXPECT_EQ(worker.NextGrant().job_id(), second.id());
  EXPECT_EQ(ControlOrDie(first.id(), Request::ACTION_SET_PRIORITY, 6).priority(), 6);
  worker.Credit(1);
  EXPECT_EQ(worker.NextGrant().job_id(), first.id());
  StopCoordinator();
  StartCoordinator();
  EXPECT_EQ(Get(first.id()).priority(), 6);
  EXPECT_EQ(SubmitOrDie(urgent).id(), second.id());
  v1::Job refused;
  EXPECT_EQ(Control(first.id(), Request::ACTION_SET_PRIORITY, refused, 1001).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Control(first.id(), Request::ACTION_UNSPECIFIED, refused).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Control(MakeUuid(), Request::ACTION_PAUSE, refused).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(JobControlTest, JobBeginsWhenTheOneBeforeItHasSucceededAndNotWhenItHasFailed) {
  const v1::Job before = SubmitOrDie(TriangleJob(0, 0, 32, 32));
  v1::SubmitRequest request = TriangleJob(0, 0, 32, 32);
  request.add_after(before.id());
  const v1::Job after = SubmitOrDie(request);
  EXPECT_THAT(after.after(), ElementsAre(before.id()));
  EXPECT_THAT(after.waits_for(), ElementsAre(before.id()));
  {
    FakeWorker worker(channel_);
    for (int i = 0; i < 3; ++i) worker.FailNext("no");
    EXPECT_EQ(WaitForEnd(before.id()).state(), v1::JOB_STATE_FAILED);
    EXPECT_THAT(Get(after.id()).waits_for(), ElementsAre(before.id()));
  }
  StopCoordinator();
  StartCoordinator();
  EXPECT_THAT(Get(after.id()).waits_for(), ElementsAre(before.id()));
  EXPECT_EQ(ControlOrDie(before.id(), Request::ACTION_RETRY).state(), v1::JOB_STATE_QUEUED);
  FakeWorker worker(channel_);
  worker.Credit(2);
  const v1::Grant first = worker.NextGrant();
  EXPECT_EQ(first.job_id(), before.id());
  worker.Render(first);
  EXPECT_EQ(worker.NextGrant().job_id(), after.id());
  EXPECT_EQ(Get(before.id()).state(), v1::JOB_STATE_SUCCEEDED);
  EXPECT_EQ(Get(after.id()).waits_for_size(), 0);
}

TEST_F(JobControlTest, TilesComeInTheOrderThatTheJobAsksForAndMakeTheSameFrame) {
  std::string frame;
  for (const auto& [wire, order] : {std::pair{v1::TILE_ORDER_UNSPECIFIED, TileOrder::kHilbert},
                                    {v1::TILE_ORDER_HILBERT, TileOrder::kHilbert},
                                    {v1::TILE_ORDER_CENTER, TileOrder::kCenter},
                                    {v1::TILE_ORDER_COARSE, TileOrder::kCoarse}}) {
    SCOPED_TRACE(std::string(ToString(order)));
    v1::SubmitRequest request = TriangleJob(1, 1, 330, 300);
    request.mutable_spec()->set_order(wire);
    const v1::Job job = SubmitOrDie(request);
    // The order is of the job, over a restart too.
    if (wire == v1::TILE_ORDER_COARSE) {
      StopCoordinator();
      StartCoordinator();
    }
    EXPECT_EQ(Get(job.id()).spec().order(),
              wire == v1::TILE_ORDER_UNSPECIFIED ? v1::TILE_ORDER_HILBERT : wire);
    std::vector<uint32_t> tiles;
    FakeWorker worker(channel_);
    while (tiles.size() < 110) {
      worker.Credit(1);
      const v1::Grant grant = worker.NextGrant();
      tiles.insert(tiles.end(), grant.tiles().begin(), grant.tiles().end());
      worker.Render(grant);
    }
    EXPECT_EQ(tiles, OrderTiles(order, 11, 10));
    EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
    std::string bytes;
    v1::FrameChunk first;
    ASSERT_TRUE(Fetch(job.id(), 1, 0, bytes, first).ok());
    if (frame.empty()) frame = bytes;
    EXPECT_EQ(bytes, frame);
  }
}

TEST_F(JobControlTest, WishesAreCheckedByName) {
  const auto expect = [&](const char* what, grpc::StatusCode code,
                          const std::function<void(v1::SubmitRequest&)>& change) {
    v1::SubmitRequest request = TriangleJob(0, 0, 32, 32);
    change(request);
    v1::Job job;
    const grpc::Status status = Submit(request, job);
    EXPECT_EQ(status.error_code(), code) << what << ": " << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(what));
  };
  using enum grpc::StatusCode;
  expect("priority: is -1001", INVALID_ARGUMENT, [](auto& r) { r.set_priority(-1001); });
  expect("user: has 129", INVALID_ARGUMENT, [](auto& r) { r.set_user(std::string(129, 'u')); });
  expect("after: there is no job", NOT_FOUND, [](auto& r) { r.add_after(MakeUuid()); });
  expect("after: there is no job", NOT_FOUND, [](auto& r) { r.add_after("' OR 1=1 --"); });
  const std::string id = SubmitOrDie(TriangleJob(0, 0, 32, 32)).id();
  expect("twice", INVALID_ARGUMENT, [&](auto& r) {
    r.add_after(id);
    r.add_after(id);
  });
  expect("after: names 65", INVALID_ARGUMENT, [&](auto& r) {
    for (int i = 0; i < 65; ++i) r.add_after(id);
  });
}

TEST_F(JobControlTest, RetryOfACancelledJobRendersWhatIsMissingAndKeepsFinishedFrames) {
  const v1::Job job = SubmitOrDie(TriangleJob(1, 2, 32, 32));
  FakeWorker worker(channel_);
  worker.Credit(1);
  worker.Render(worker.NextGrant());
  WatchUntil(job.id(), [](const v1::Job& j) { return j.frames_finished() == 1; });
  v1::Job cancelled;
  ASSERT_TRUE(Cancel(job.id(), cancelled).ok());
  const v1::Job again = ControlOrDie(job.id(), Request::ACTION_RETRY);
  EXPECT_EQ(again.state(), v1::JOB_STATE_RUNNING);
  EXPECT_EQ(again.frames_finished(), 1u);
  worker.Credit(1);
  const v1::Grant grant = worker.NextGrant();
  EXPECT_EQ(grant.frame(), 2);
  worker.Render(grant);
  const v1::Job ended = WaitForEnd(job.id());
  EXPECT_EQ(ended.state(), v1::JOB_STATE_SUCCEEDED);
  EXPECT_EQ(ControlOrDie(job.id(), Request::ACTION_RETRY).state(), v1::JOB_STATE_SUCCEEDED);
  ExpectSyntheticFrame(job.id(), 1, 32, 32);
  ExpectSyntheticFrame(job.id(), 2, 32, 32);
}

}  // namespace
}  // namespace shutterline::server
