#include <absl/synchronization/notification.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/build_id.h"
#include "tests/worker/worker_test.h"

namespace shutterline::worker {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class WorkerSessionTest : public WorkerTest {};

TEST_F(WorkerSessionTest, SaysWhoItIsAndAsksForThreeLeasesASlot) {
  StartWorker(2);
  const State state = coordinator_.WaitFor([](const State& s) { return s.credit > 0; });
  EXPECT_EQ(state.credit, 6u);
  const v1::Hello& hello = state.hellos[0];
  EXPECT_EQ(hello.slots(), 2u);
  EXPECT_EQ(hello.build_id(), kBuildId);
  EXPECT_EQ(hello.name(), "test worker");
  EXPECT_FALSE(hello.worker_uuid().empty());
  EXPECT_NE(hello.worker_uuid(), hello.boot_id());
  EXPECT_THAT(hello.isa(), testing::AnyOf("x86-64", "avx2", "avx512", "aarch64", "unknown"));
  EXPECT_LE(hello.protocol().low(), hello.protocol().high());
  EXPECT_EQ(state.opens[0].session_id(), "session-101");
  EXPECT_EQ(state.opens[0].epoch(), 101u);
}

TEST_F(WorkerSessionTest, RendersEveryTileOfAFrame) {
  StartWorker(2);
  SendJob();
  coordinator_.Grant(1, "job-1", 5, {0, 1, 2, 3, 4, 5});
  coordinator_.Grant(2, "job-1", 5, {6, 7, 8, 9, 10, 11});
  const State state = coordinator_.WaitFor([](const State& s) { return s.results.size() >= 12; });
  EXPECT_EQ(TilesOf(state.results), (std::multiset<uint32_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}));
  for (const v1::TileResult& result : state.results) {
    EXPECT_EQ(result.job_id(), "job-1");
    EXPECT_EQ(result.frame(), 5);
    EXPECT_EQ(result.lease_id(), result.tile() < 6 ? 1u : 2u);
    ExpectPixels(result);
    EXPECT_EQ(result.stats().tiles(), 1);
    EXPECT_EQ(result.stats().lines() * 16, int64_t(result.pixels().size()));
    EXPECT_EQ(result.stats().resolve_seconds(), 0.5);
  }
  EXPECT_EQ(engine_.imports, 1);
  EXPECT_EQ(engine_.frames, 1);
}

TEST_F(WorkerSessionTest, RefillsCreditBelowTwoLeasesASlot) {
  StartWorker(1);
  coordinator_.WaitFor([](const State& s) { return s.credit == 3; });
  SendJob();
  // Three leases, one tile each, take all credit. After two of them, one is held: below 2, so 2 more.
  uint64_t granted = 0;
  for (int round = 0; round < 10; ++round) {
    const State before = coordinator_.WaitFor([&](const State& s) { return s.credit > granted; });
    for (; granted < before.credit; ++granted) coordinator_.Grant(granted + 1, "job-1", round, {0});
  }
  const State state = coordinator_.WaitFor([&](const State& s) { return s.results.size() >= granted; });
  EXPECT_GE(granted, 12u);
  // Never more than 3 leases are held or can be granted: what was given is what was used, and 3.
  EXPECT_LE(state.credit, granted + 3);
}

TEST_F(WorkerSessionTest, AStaleEpochRegistersAgain) {
  int refusals = 3;
  coordinator_.AnswerOpen([&](const v1::Open&) {
    return refusals-- > 0 ? grpc::Status(grpc::StatusCode::ABORTED, "stale epoch") : grpc::Status::OK;
  });
  StartWorker();
  const State state = coordinator_.WaitFor([](const State& s) { return s.credit > 0; });
  EXPECT_EQ(state.hellos.size(), 4u);
  ASSERT_EQ(state.opens.size(), 4u);
  EXPECT_EQ(state.opens[3].epoch(), 104u) << "the epoch of the latest registration";
  for (const v1::Hello& hello : state.hellos) {
    EXPECT_EQ(hello.worker_uuid(), state.hellos[0].worker_uuid());
    EXPECT_EQ(hello.boot_id(), state.hellos[0].boot_id());
  }
}

TEST_F(WorkerSessionTest, KeepsTryingWhileTheCoordinatorIsAway) {
  std::atomic<int> attempts = 0;
  coordinator_.AnswerRegister([&](const v1::Hello&) {
    return ++attempts < 5 ? grpc::Status(grpc::StatusCode::UNAVAILABLE, "starting") : grpc::Status::OK;
  });
  StartWorker();
  coordinator_.WaitFor([](const State& s) { return s.credit > 0; });
  EXPECT_EQ(attempts, 5);
}

TEST_F(WorkerSessionTest, AnotherBuildEndsTheWorkerWithTheReason) {
  coordinator_.AnswerRegister([](const v1::Hello& hello) {
    return grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                        "this coordinator is build A, the worker " + hello.build_id());
  });
  StartWorker();
  const absl::Status end = worker_->Wait();
  EXPECT_EQ(end.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(end.message()), HasSubstr(kBuildId));
}

TEST_F(WorkerSessionTest, ABrokenStreamLosesNoResultAndSendsNoneTwice) {
  StartWorker(1);
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {0, 1, 2});
  coordinator_.WaitFor([](const State& s) { return s.results.size() == 3; });
  WaitUntilNothingIsHeld();  // All acknowledged; what comes now is not.
  coordinator_.Acknowledge(false);
  coordinator_.Grant(2, "job-1", 0, {3, 4, 5, 6, 7});
  coordinator_.WaitFor([](const State& s) { return s.results.size() == 8; });
  coordinator_.Acknowledge(true);
  coordinator_.BreakStreams();

  coordinator_.WaitFor([](const State& s) { return s.sessions == 2 && s.results.size() >= 13; });
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
  const State state = coordinator_.state();
  EXPECT_EQ(TilesOf(state.results), (std::multiset<uint32_t>{0, 1, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7}));
  for (size_t i = 0; i < state.results.size(); ++i) {
    ExpectPixels(state.results[i]);
    EXPECT_EQ(state.result_epochs[i], i < 8 ? 101u : 102u);
    // Lease numbers mean nothing to another session.
    if (i >= 8) {
      EXPECT_EQ(state.results[i].lease_id(), 0u);
    }
  }
  EXPECT_EQ(engine_.tiles, 8) << "sent again, not rendered again";
}

/// One worker thread that is at tile 7 and has tile 8 waiting when its streams break.
class WorkerAdoptionTest : public WorkerTest {
 protected:
  void BreakInMidLease() {
    engine_.before_tile = [&](const TileRect&, int) {
      if (!started_.HasBeenNotified()) started_.Notify();
      go_on_.WaitForNotification();
      return absl::OkStatus();
    };
    StartWorker(1);
    SendJob();
    coordinator_.Grant(1, "job-1", 0, {7, 8});
    started_.WaitForNotification();
    coordinator_.BreakStreams();
    const State state = coordinator_.WaitFor([](const State& s) { return s.sessions == 2 && s.credit > 0; });
    EXPECT_EQ(state.opens[0].held_size(), 0);
    ASSERT_EQ(state.opens[1].held_size(), 1);
    held_ = state.opens[1].held(0);
    EXPECT_EQ(held_.job_id(), "job-1");
    EXPECT_EQ(held_.frame(), 0);
    EXPECT_THAT(held_.tiles(), ElementsAre(7u, 8u));
    SendJob();
  }

  absl::Notification started_, go_on_;
  v1::HeldLease held_;
};

TEST_F(WorkerAdoptionTest, WhatIsAdoptedIsRenderedOnce) {
  BreakInMidLease();
  v1::CoordinatorMessage message;
  v1::Grant& grant = *message.mutable_grant();
  grant.set_lease_id(9);
  grant.set_job_id("job-1");
  grant.add_tiles(7);
  grant.add_tiles(8);
  grant.set_adopts(held_.ticket());
  coordinator_.Send(message);
  message.mutable_adopted();
  coordinator_.Send(message);
  coordinator_.WaitFor(
      [](const State& s) { return !s.heartbeats.empty() && s.heartbeats.back().size() == 1; });
  EXPECT_THAT(coordinator_.state().heartbeats.back(), ElementsAre(9u));
  go_on_.Notify();
  const State state = coordinator_.WaitFor([](const State& s) { return s.results.size() == 2; });
  EXPECT_EQ(TilesOf(state.results), (std::multiset<uint32_t>{7, 8}));
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
  EXPECT_EQ(engine_.tiles, 2);
}

TEST_F(WorkerAdoptionTest, WhatIsNotAdoptedIsDroppedButForTheTileUnderWay) {
  BreakInMidLease();
  v1::CoordinatorMessage message;
  message.mutable_adopted();
  coordinator_.Send(message);
  coordinator_.Grant(50, "job-1", 0, {3});  // Once this is named, what came before has been read.
  coordinator_.WaitFor(
      [](const State& s) { return !s.heartbeats.empty() && s.heartbeats.back().size() == 1; });
  go_on_.Notify();
  const State state = coordinator_.WaitFor([](const State& s) { return s.results.size() == 2; });
  EXPECT_EQ(TilesOf(state.results), (std::multiset<uint32_t>{3, 7}));
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
  EXPECT_EQ(engine_.tiles, 2);
}

TEST_F(WorkerSessionTest, TilesThatOthersHaveDeliveredAreNotRendered) {
  absl::Notification started, go_on;
  engine_.before_tile = [&](const TileRect&, int) {
    if (!started.HasBeenNotified()) {
      started.Notify();
      go_on.WaitForNotification();
    }
    return absl::OkStatus();
  };
  StartWorker(1);
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {7, 8, 9, 10});
  started.WaitForNotification();
  v1::CoordinatorMessage message;
  v1::RevokedTiles& revoked = *message.mutable_revoke()->add_tiles();
  revoked.set_lease_id(1);
  for (const uint32_t tile : {7, 8, 10}) revoked.add_tiles(tile);
  coordinator_.Send(message);
  coordinator_.Grant(2, "job-1", 0, {8});  // Once this is named, what came before has been read.
  coordinator_.WaitFor(
      [](const State& s) { return !s.heartbeats.empty() && s.heartbeats.back().size() == 2; });
  EXPECT_THAT(coordinator_.state().heartbeats.back(), ElementsAre(1u, 2u));
  go_on.Notify();
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
  const State state = coordinator_.state();
  // What was under way comes all the same, and the other lease keeps its tile of the same number.
  EXPECT_EQ(TilesOf(state.results), (std::multiset<uint32_t>{7, 8, 9}));
  for (const v1::TileResult& result : state.results)
    EXPECT_EQ(result.lease_id(), result.tile() == 8 ? 2u : 1u);
  EXPECT_EQ(engine_.tiles, 3);
}

TEST_F(WorkerSessionTest, HeartbeatsGoOnDuringALongTile) {
  absl::Notification started, go_on;
  engine_.before_tile = [&](const TileRect&, int) {
    started.Notify();
    go_on.WaitForNotification();
    return absl::OkStatus();
  };
  StartWorker(1);
  SendJob();
  coordinator_.Grant(42, "job-1", 0, {0});
  started.WaitForNotification();
  const size_t before = coordinator_.state().heartbeats.size();
  const State state = coordinator_.WaitFor([&](const State& s) { return s.heartbeats.size() >= before + 4; });
  EXPECT_THAT(state.heartbeats.back(), ElementsAre(42u));
  go_on.Notify();
  coordinator_.WaitFor([](const State& s) { return s.heartbeats.back().empty(); });
}

}  // namespace
}  // namespace shutterline::worker
