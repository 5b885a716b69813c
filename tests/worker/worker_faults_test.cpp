#include <absl/synchronization/notification.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

#include "tests/worker/worker_test.h"

namespace shutterline::worker {
namespace {

using testing::HasSubstr;

class WorkerFaultsTest : public WorkerTest {};

TEST_F(WorkerFaultsTest, RevokedTilesAreNotRendered) {
  absl::Notification started, go_on;
  engine_.before_tile = [&](const TileRect&, int) {
    if (!started.HasBeenNotified()) started.Notify();
    go_on.WaitForNotification();
    return absl::OkStatus();
  };
  StartWorker(1);
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {0, 1, 2});
  coordinator_.Grant(2, "job-1", 0, {3});
  started.WaitForNotification();
  v1::CoordinatorMessage revoke;
  revoke.mutable_revoke()->add_lease_ids(1);
  coordinator_.Send(revoke);
  coordinator_.WaitFor([](const State& s) {
    return !s.heartbeats.empty() && s.heartbeats.back() == std::vector<uint64_t>{2};
  });
  go_on.Notify();
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
  EXPECT_EQ(TilesOf(coordinator_.state().results), (std::multiset<uint32_t>{0, 3}));
}

TEST_F(WorkerFaultsTest, AnEndedJobStopsBetweenTiles) {
  absl::Notification started, go_on;
  engine_.before_tile = [&](const TileRect&, int) {
    if (!started.HasBeenNotified()) started.Notify();
    go_on.WaitForNotification();
    return absl::OkStatus();
  };
  StartWorker(1);
  SendJob("ended");
  SendJob("alive");
  coordinator_.Grant(1, "ended", 0, {0, 1, 2});
  coordinator_.Grant(2, "alive", 0, {3});
  started.WaitForNotification();
  v1::CoordinatorMessage message;
  message.mutable_forget_job()->set_job_id("ended");
  coordinator_.Send(message);
  message.mutable_revoke()->add_lease_ids(1);
  coordinator_.Send(message);
  coordinator_.WaitFor([](const State& s) {
    return !s.heartbeats.empty() && s.heartbeats.back() == std::vector<uint64_t>{2};
  });
  go_on.Notify();
  const State state = coordinator_.WaitFor([](const State& s) { return !s.results.empty(); });
  EXPECT_EQ(state.results[0].job_id(), "alive");
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
  EXPECT_EQ(coordinator_.state().results.size(), 1u);
  EXPECT_EQ(engine_.tiles, 2);
}

TEST_F(WorkerFaultsTest, DrainFinishesWhatIsLeasedAndLeaves) {
  absl::Notification started, go_on;
  engine_.before_tile = [&](const TileRect&, int) {
    if (!started.HasBeenNotified()) started.Notify();
    go_on.WaitForNotification();
    return absl::OkStatus();
  };
  StartWorker(1);
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {0, 1});
  coordinator_.Grant(2, "job-1", 0, {2, 3});
  started.WaitForNotification();
  // Both grants have been seen before the worker is told to leave.
  coordinator_.WaitFor([](const State& s) {
    return !s.heartbeats.empty() && s.heartbeats.back() == std::vector<uint64_t>{1, 2};
  });
  worker_->Drain();
  const State draining = coordinator_.WaitFor([](const State& s) { return s.draining == 1; });
  go_on.Notify();
  EXPECT_TRUE(worker_->Wait().ok());
  const State state = coordinator_.WaitFor([](const State& s) { return s.sessions_open == 0; });
  EXPECT_EQ(TilesOf(state.results), (std::multiset<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(state.credit, draining.credit) << "no credit after Draining";
  EXPECT_EQ(state.sessions, 1);
}

TEST_F(WorkerFaultsTest, DrainWithoutCoordinatorAndWithoutResultsLeavesAtOnce) {
  coordinator_.AnswerRegister(
      [](const v1::Hello&) { return grpc::Status(grpc::StatusCode::UNAVAILABLE, "starting"); });
  StartWorker();
  coordinator_.WaitFor([](const State& s) { return s.hellos.size() > 2; });
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
}

TEST_F(WorkerFaultsTest, DrainGivesUpOnACoordinatorThatStaysAway) {
  patience_ = absl::Milliseconds(50);
  coordinator_.Acknowledge(false);
  StartWorker();
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {0});
  coordinator_.WaitFor([](const State& s) { return s.results.size() == 1; });
  coordinator_.AnswerRegister(
      [](const v1::Hello&) { return grpc::Status(grpc::StatusCode::UNAVAILABLE, "gone"); });
  coordinator_.BreakStreams();
  worker_->Drain();
  const absl::Status end = worker_->Wait();
  EXPECT_EQ(end.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(end.message()), HasSubstr("1 tiles undelivered"));
}

TEST_F(WorkerFaultsTest, FailuresAreReportedAndTheWorkerGoesOn) {
  engine_.before_tile = [](const TileRect& rect, int) -> absl::Status {
    if (rect.x == 0) return absl::InvalidArgumentError("the left column is broken");
    if (rect.x == 32) throw std::runtime_error("thrown by the engine");
    if (rect.x == 64) throw 5;
    return absl::OkStatus();
  };
  StartWorker(2);
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {0, 1, 2, 3, 12, 4'000'000'000});
  const State state = coordinator_.WaitFor([](const State& s) { return s.results.size() == 6; });
  for (const v1::TileResult& result : state.results) {
    if (result.tile() == 3) {
      ExpectPixels(result);
      continue;
    }
    ASSERT_TRUE(result.has_failure()) << result.tile();
    const std::string& message = result.failure().message();
    switch (result.tile()) {
      case 0:
        EXPECT_EQ(result.failure().code(), int(absl::StatusCode::kInvalidArgument));
        EXPECT_THAT(message, HasSubstr("the left column is broken"));
        break;
      case 1:
        EXPECT_EQ(result.failure().code(), int(absl::StatusCode::kInternal));
        EXPECT_THAT(message, HasSubstr("thrown by the engine"));
        break;
      case 2:
        EXPECT_THAT(message, HasSubstr("unknown exception"));
        break;
      default:
        EXPECT_THAT(message, HasSubstr("does not exist"));
    }
  }
}

TEST_F(WorkerFaultsTest, ScenesThatDoNotLoadFailTheirTiles) {
  engine_.before_import = [] { return absl::InvalidArgumentError("accessor 7: out of range"); };
  StartWorker(2);
  SendJob();
  coordinator_.SendJob("no-blob", 64, 64, Sha256("never uploaded"));
  v1::CoordinatorMessage nonsense;
  nonsense.mutable_job()->set_job_id("nonsense");
  coordinator_.Send(nonsense);
  coordinator_.Grant(1, "job-1", 0, {0, 1});
  coordinator_.Grant(2, "no-blob", 0, {2});
  coordinator_.Grant(3, "nonsense", 0, {3});
  const State state = coordinator_.WaitFor([](const State& s) { return s.results.size() == 4; });
  std::map<uint32_t, v1::TileFailure> failures;
  for (const v1::TileResult& result : state.results) failures[result.tile()] = result.failure();
  EXPECT_THAT(failures[0].message(), HasSubstr("accessor 7"));
  EXPECT_THAT(failures[1].message(), HasSubstr("accessor 7"));
  EXPECT_THAT(failures[3].message(), HasSubstr("render"));
  EXPECT_EQ(failures[3].code(), int(absl::StatusCode::kInvalidArgument));
  EXPECT_NE(failures[2].code(), 0);
}

TEST_F(WorkerFaultsTest, ALeaseOfAnUnknownJobIsReturned) {
  StartWorker(1);
  coordinator_.Grant(9, "who", 0, {0});
  coordinator_.WaitFor([](const State& s) { return s.returned == std::vector<uint64_t>{9}; });
}

TEST_F(WorkerFaultsTest, AFullBufferPausesRenderingUntilAcknowledged) {
  // A full tile is 16 KiB: the second result fills the buffer.
  coordinator_.Acknowledge(false);
  StartWorker(1, 20 << 10);
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {0, 1, 2, 4, 5, 6});
  coordinator_.WaitFor([](const State& s) { return s.results.size() == 2; });
  // Three more heartbeats later nothing else has been rendered.
  const size_t before = coordinator_.state().heartbeats.size();
  coordinator_.WaitFor([&](const State& s) { return s.heartbeats.size() >= before + 3; });
  EXPECT_EQ(engine_.tiles, 2);
  coordinator_.Acknowledge(true);
  coordinator_.BreakStreams();
  coordinator_.WaitFor([](const State& s) { return s.results.size() == 4; });
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {2, 4, 5, 6});
  coordinator_.WaitFor([](const State& s) { return TilesOf(s.results).contains(6); });
}

TEST_F(WorkerFaultsTest, UnwantedTilesAreNotSentAgain) {
  coordinator_.SetOutcome(v1::ResultAck::OUTCOME_UNWANTED);
  StartWorker(1);
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {0});
  coordinator_.WaitFor([](const State& s) { return s.results.size() == 1; });
  WaitUntilNothingIsHeld();
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
  EXPECT_EQ(coordinator_.state().results.size(), 1u);
}

TEST_F(WorkerFaultsTest, StopLeavesAtOnce) {
  coordinator_.Acknowledge(false);
  StartWorker(2);
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {0, 1, 2});
  coordinator_.WaitFor([](const State& s) { return s.results.size() == 3; });
  worker_->Stop();
  EXPECT_EQ(worker_->Wait().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace shutterline::worker
