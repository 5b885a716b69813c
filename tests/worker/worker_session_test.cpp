#include <absl/strings/str_cat.h>
#include <absl/synchronization/notification.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "common/base/build_id.h"
#include "tests/worker/fake_coordinator.h"
#include "tests/worker/fake_renderer.h"
#include "worker/worker.h"

namespace shutterline::worker {
namespace {

using State = FakeCoordinator::State;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Which tiles of a frame have come, in order of number; with repetitions.
std::multiset<uint32_t> TilesOf(const std::vector<v1::TileResult>& results) {
  std::multiset<uint32_t> tiles;
  for (const v1::TileResult& result : results) tiles.insert(result.tile());
  return tiles;
}

class WorkerSessionTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = (std::filesystem::temp_directory_path() / "worker_session_test.XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    scene_ = coordinator_.PutBlob("a scene of more than one chunk");
  }
  void TearDown() override {
    worker_.reset();
    std::filesystem::remove_all(folder_);
  }

  void StartWorker(int threads = 2, size_t max_result_bytes = 64 << 20) {
    WorkerOptions options;
    options.name = "test worker";
    options.threads = threads;
    options.cache_dir = folder_;
    options.max_result_bytes = max_result_bytes;
    options.backoff_initial = absl::Milliseconds(1);
    options.backoff_max = absl::Milliseconds(10);
    options.drain_patience = patience_;
    auto worker = Worker::Start(coordinator_.Channel(), options, engine_);
    ASSERT_TRUE(worker.ok()) << worker.status();
    worker_ = *std::move(worker);
  }

  /// A job whose frames have 4 × 3 tiles, the last ones of a row and column cut.
  void SendJob(const std::string& id = "job-1") { coordinator_.SendJob(id, 100, 90, scene_); }

  /// Until a heartbeat names no lease, other than one that was on its way already.
  void WaitUntilNothingIsHeld() {
    const size_t before = coordinator_.state().heartbeats.size();
    coordinator_.WaitFor(
        [&](const State& s) { return s.heartbeats.size() >= before + 2 && s.heartbeats.back().empty(); });
  }

  static void ExpectPixels(const v1::TileResult& result) {
    ASSERT_TRUE(result.has_rgba()) << result.failure().message();
    const TileRect rect = TileGrid{100, 90}.Rect(int(result.tile()));
    std::vector<float> expected(size_t(rect.Area()) * 4);
    FakeRenderer::Expected(rect, result.frame(), expected);
    ASSERT_EQ(result.rgba().size(), expected.size() * sizeof(float));
    EXPECT_EQ(std::memcmp(result.rgba().data(), expected.data(), result.rgba().size()), 0);
  }

  std::filesystem::path folder_;
  absl::Duration patience_ = absl::Seconds(30);
  FakeCoordinator coordinator_;
  FakeRenderer engine_;
  Digest scene_;
  std::unique_ptr<Worker> worker_;
};

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

TEST_F(WorkerSessionTest, ATileUnderWayDuringTheBreakIsDelivered) {
  absl::Notification started, go_on;
  engine_.before_tile = [&](const TileRect&, int) {
    if (!started.HasBeenNotified()) started.Notify();
    go_on.WaitForNotification();
    return absl::OkStatus();
  };
  StartWorker(1);
  SendJob();
  coordinator_.Grant(1, "job-1", 0, {7, 8});
  started.WaitForNotification();
  coordinator_.BreakStreams();
  coordinator_.WaitFor([](const State& s) { return s.sessions == 2 && s.credit > 0; });
  go_on.Notify();
  const State state = coordinator_.WaitFor([](const State& s) { return !s.results.empty(); });
  EXPECT_EQ(state.results[0].tile(), 7u);
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
  EXPECT_EQ(coordinator_.state().results.size(), 1u) << "tile 8 waited: its lease ended with the session";
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

TEST_F(WorkerSessionTest, RevokedTilesAreNotRendered) {
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

TEST_F(WorkerSessionTest, AnEndedJobStopsBetweenTiles) {
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

TEST_F(WorkerSessionTest, DrainFinishesWhatIsLeasedAndLeaves) {
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

TEST_F(WorkerSessionTest, DrainWithoutCoordinatorAndWithoutResultsLeavesAtOnce) {
  coordinator_.AnswerRegister(
      [](const v1::Hello&) { return grpc::Status(grpc::StatusCode::UNAVAILABLE, "starting"); });
  StartWorker();
  coordinator_.WaitFor([](const State& s) { return s.hellos.size() > 2; });
  worker_->Drain();
  EXPECT_TRUE(worker_->Wait().ok());
}

TEST_F(WorkerSessionTest, DrainGivesUpOnACoordinatorThatStaysAway) {
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

TEST_F(WorkerSessionTest, FailuresAreReportedAndTheWorkerGoesOn) {
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

TEST_F(WorkerSessionTest, ScenesThatDoNotLoadFailTheirTiles) {
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

TEST_F(WorkerSessionTest, ALeaseOfAnUnknownJobIsReturned) {
  StartWorker(1);
  coordinator_.Grant(9, "who", 0, {0});
  coordinator_.WaitFor([](const State& s) { return s.returned == std::vector<uint64_t>{9}; });
}

TEST_F(WorkerSessionTest, AFullBufferPausesRenderingUntilAcknowledged) {
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

TEST_F(WorkerSessionTest, UnwantedTilesAreNotSentAgain) {
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

TEST_F(WorkerSessionTest, StopLeavesAtOnce) {
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
