#include <absl/synchronization/notification.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/fake_clock.h"
#include "tests/worker/worker_test.h"

namespace shutterline::worker {
namespace {

using testing::ElementsAre;

/// A worker of two threads whose time stands still, told to gather results for a second: what it sends it
/// sends because something has happened. The first thread that gets tile 0 stays at it until `go_on`.
class WorkerGatherTest : public WorkerTest {
 protected:
  void SetUp() override {
    WorkerTest::SetUp();
    coordinator_.SetGather(absl::Seconds(1));
    engine_.before_tile = [this](const TileRect& rect, int) {
      if (rect.x == 0 && rect.y == 0) go_on_.WaitForNotification();
      return absl::OkStatus();
    };
  }
  void TearDown() override {
    if (!go_on_.HasBeenNotified()) go_on_.Notify();
    WorkerTest::TearDown();
  }
  void Start(int threads = 2) {
    StartWorker(threads, 64 << 20, clock_);
    SendJob();
  }
  void NotifyAtTileThree(absl::Notification& at_three) {
    engine_.before_tile = [&](const TileRect& rect, int) {
      if (rect.x == 0 && rect.y == 0) go_on_.WaitForNotification();
      if (rect.x == 96 && rect.y == 0) at_three.Notify();
      return absl::OkStatus();
    };
  }
  State WaitForResults(size_t count) {
    return coordinator_.WaitFor([&](const State& s) { return s.results.size() >= count; });
  }
  void Send(const std::function<void(v1::CoordinatorMessage&)>& fill) {
    v1::CoordinatorMessage message;
    fill(message);
    coordinator_.Send(message);
  }

  test::FakeClock clock_;
  absl::Notification go_on_;
};

TEST_F(WorkerGatherTest, WhatAWorkerHoldsOfAFrameComesInOneMessage) {
  go_on_.Notify();
  Start();
  coordinator_.Grant(1, "job-1", 5, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  EXPECT_THAT(WaitForResults(12).batches, ElementsAre(12));
}

TEST_F(WorkerGatherTest, AFrameIsNotHeldUpByTheNextOne) {
  Start();
  coordinator_.Grant(1, "job-1", 6, {0});
  coordinator_.Grant(2, "job-1", 5, {1, 2, 3});
  const State state = WaitForResults(3);  // While the other thread is at frame 6.
  EXPECT_EQ(TilesOf(state.results), (std::multiset<uint32_t>{1, 2, 3}));
}

TEST_F(WorkerGatherTest, BeforeATileThatOthersHaveNotBroughtBackEverythingIsSent) {
  absl::Notification at_seven;
  engine_.before_tile = [&](const TileRect& rect, int) {
    if (rect.x == 0 && rect.y == 0) go_on_.WaitForNotification();
    if (rect.x == 96 && rect.y == 32) at_seven.WaitForNotification();
    return absl::OkStatus();
  };
  Start();
  coordinator_.Grant(1, "job-1", 5, {0, 1, 2});
  coordinator_.Grant(2, "job-1", 5, {7, 8, 9}, true);
  EXPECT_EQ(TilesOf(WaitForResults(2).results), (std::multiset<uint32_t>{1, 2}));
  at_seven.Notify();
  // Each as it comes, though the frame is not through.
  EXPECT_EQ(TilesOf(WaitForResults(5).results), (std::multiset<uint32_t>{1, 2, 7, 8, 9}));
}

TEST_F(WorkerGatherTest, WhatWasToBeSentWithARevokedTileDoesNotWaitForIt) {
  absl::Notification at_three;
  NotifyAtTileThree(at_three);
  Start();
  coordinator_.Grant(1, "job-1", 5, {0, 1, 2, 3});
  at_three.WaitForNotification();  // So 1 and 2 have been rendered.
  Send([](v1::CoordinatorMessage& message) { message.mutable_revoke()->add_lease_ids(1); });
  WaitForResults(2);
}

TEST_F(WorkerGatherTest, AnAcknowledgementChangesThePace) {
  coordinator_.SetGatherOfAcks(absl::ZeroDuration());
  Start();
  coordinator_.Grant(1, "job-1", 5, {0});
  coordinator_.Grant(2, "job-1", 5, {1}, true);
  WaitForResults(1);
  coordinator_.Grant(3, "job-1", 5, {2});
  WaitForResults(2);  // Though the frame is not through.
}

TEST_F(WorkerGatherTest, AWorkerThatLeavesKeepsNothingBack) {
  absl::Notification at_three;
  NotifyAtTileThree(at_three);
  Start();
  coordinator_.Grant(1, "job-1", 5, {0, 1, 2, 3});
  at_three.WaitForNotification();
  worker_->Drain();
  EXPECT_EQ(TilesOf(WaitForResults(3).results), (std::multiset<uint32_t>{1, 2, 3}));
  go_on_.Notify();
  EXPECT_TRUE(worker_->Wait().ok());
  EXPECT_EQ(coordinator_.state().results.size(), 4u);
}

TEST_F(WorkerGatherTest, WhatWaitedWhenTheStreamBrokeIsSentByTheNextSession) {
  absl::Notification at_three;
  NotifyAtTileThree(at_three);
  Start();
  coordinator_.Grant(1, "job-1", 5, {0, 1, 2, 3});
  at_three.WaitForNotification();
  coordinator_.BreakStreams();
  // It waits for a while before it registers again.
  while (coordinator_.state().sessions < 2) clock_.Advance(absl::Milliseconds(1));
  const State state = WaitForResults(2);
  EXPECT_THAT(state.opens.back().held(), testing::SizeIs(1));
}

TEST_F(WorkerGatherTest, CreditComesWithResults) {
  Start(1);
  // A lease that came before the first wish would make it smaller.
  coordinator_.WaitFor([](const State& s) { return s.credit == 3; });
  for (uint64_t lease = 1; lease <= 4; ++lease) {
    coordinator_.Grant(lease, "job-1", int(lease), {1});
    coordinator_.WaitFor([&](const State& s) { return s.credit_with_results >= lease; });
  }
  EXPECT_EQ(coordinator_.state().credit_with_results, 4u);
  EXPECT_EQ(coordinator_.state().credit, 3u) << "in a message of its own, but at first";
}

TEST_F(WorkerGatherTest, AWorkerThatNeedsLeasesSendsItsResultsWithTheWish) {
  Start();
  coordinator_.WaitFor([](const State& s) { return s.credit == 6; });
  coordinator_.Grant(1, "job-1", 5, {0, 1});
  // Six leases were asked for. When three are rendered, three are left: fewer than two a slot.
  for (uint32_t lease = 2; lease <= 4; ++lease) coordinator_.Grant(lease, "job-1", 5, {uint32_t(lease)});
  const State state = coordinator_.WaitFor([](const State& s) { return s.credit_with_results > 0; });
  EXPECT_EQ(state.credit_with_results, 3u);
  EXPECT_EQ(state.credit, 6u);
  EXPECT_EQ(TilesOf(state.results).count(0), 0u) << "the frame is not through";
}

}  // namespace
}  // namespace shutterline::worker
