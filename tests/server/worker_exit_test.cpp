// What supervisors tell of the ends of workers, through the coordinator's services.
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::server {
namespace {

using test::FakeWorker;
using testing::HasSubstr;

v1::Hello Process(const std::string& uuid, int number) {
  v1::Hello hello = FakeWorker::MakeHello(uuid);
  hello.set_boot_id(absl::StrCat(uuid, " process ", number));
  return hello;
}

/// What a supervisor says of the process before `next`, which was at this tile.
v1::Hello After(v1::Hello next, const v1::Hello& dead, int signal, const std::string& job, uint32_t tile) {
  v1::WorkerExit& exit = *next.add_exits();
  exit.set_boot_id(dead.boot_id());
  exit.set_signal(signal);
  exit.set_log_tail("at work\nlast words\n");
  v1::TileName& name = *exit.add_tiles();
  name.set_job_id(job);
  name.set_frame(3);
  name.set_tile(tile);
  return next;
}

class WorkerExitTest : public test::CoordinatorFixture {
 protected:
  grpc::Status Register(const v1::Hello& hello) {
    const auto stub = v1::Workers::NewStub(channel_);
    grpc::ClientContext context;
    v1::Welcome welcome;
    return stub->Register(&context, hello, &welcome);
  }
};

TEST_F(WorkerExitTest, QuarantinedTileNamesSignalAndLastWordsOfThoseThatDiedOfIt) {
  const v1::Job job = SubmitOrDie(TriangleJob(3, 3, 32, 32));
  for (int i = 0; i < 3; ++i) {
    const std::string uuid = absl::StrCat("victim ", i);
    FakeWorker victim(channel_, Process(uuid, 1));
    victim.Credit(1);
    (void)victim.NextGrant();
    victim.Die();
    // Its successor is there before its stream is given up.
    FakeWorker successor(channel_, After(Process(uuid, 2), Process(uuid, 1), i == 1 ? 9 : 11, job.id(), 0));
    successor.Leave();
  }
  const v1::Job ended = WaitForEnd(job.id());
  EXPECT_EQ(ended.state(), v1::JOB_STATE_FAILED);
  const v1::Job known = Get(job.id());
  ASSERT_EQ(known.quarantined_size(), 1);
  ASSERT_EQ(known.quarantined(0).evidence_size(), 3);
  for (int i = 0; i < 3; ++i) {
    const v1::TileTrouble& trouble = known.quarantined(0).evidence(i);
    EXPECT_EQ(trouble.signal(), i == 1 ? "SIGKILL" : "SIGSEGV");
    EXPECT_EQ(trouble.log_tail(), "at work\nlast words\n");
    EXPECT_THAT(trouble.reason(), HasSubstr(trouble.signal()));
  }
  StopCoordinator();
  StartCoordinator();
  EXPECT_EQ(Get(job.id()).quarantined(0).evidence(2).log_tail(), "at work\nlast words\n") << "it is durable";
}

TEST_F(WorkerExitTest, ReportAfterTheQuarantineIsAddedToTheEvidenceOnDisk) {
  const v1::Job job = SubmitOrDie(TriangleJob(3, 3, 32, 32));
  for (int i = 0; i < 3; ++i) {
    FakeWorker victim(channel_, Process(absl::StrCat("victim ", i), 1));
    victim.Credit(1);
    (void)victim.NextGrant();
    victim.Die();
  }
  WaitForEnd(job.id());
  EXPECT_EQ(Get(job.id()).quarantined(0).evidence(1).signal(), "");
  // Of another process, of another worker, and twice of the right one.
  const v1::Hello next = Process("victim 1", 3);
  EXPECT_TRUE(Register(After(next, Process("victim 1", 2), 6, job.id(), 0)).ok());
  EXPECT_TRUE(Register(After(Process("stranger", 1), Process("victim 1", 1), 6, job.id(), 0)).ok());
  EXPECT_TRUE(Register(After(next, Process("victim 1", 1), 11, job.id(), 0)).ok());
  EXPECT_TRUE(Register(After(next, Process("victim 1", 1), 11, job.id(), 0)).ok());
  const auto check = [&] {
    const v1::Job known = Get(job.id());
    ASSERT_EQ(known.quarantined_size(), 1);
    EXPECT_EQ(known.quarantined(0).evidence(0).signal(), "");
    EXPECT_EQ(known.quarantined(0).evidence(1).signal(), "SIGSEGV");
    EXPECT_THAT(known.quarantined(0).evidence(1).reason(), testing::EndsWith("back: SIGSEGV"));
    EXPECT_EQ(known.quarantined(0).evidence(1).log_tail(), "at work\nlast words\n");
  };
  check();
  StopCoordinator();
  StartCoordinator();
  check();
}

TEST_F(WorkerExitTest, ReportsThatBreakARuleAreRefused) {
  const v1::Hello next = Process("w", 2), dead = Process("w", 1);
  const v1::Hello good = After(next, dead, 11, "no such job", 0);
  EXPECT_TRUE(Register(good).ok());
  const auto refusal = [&](auto spoil) {
    v1::Hello hello = good;
    spoil(hello);
    const grpc::Status status = Register(hello);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
    return status.error_message();
  };
  EXPECT_THAT(refusal([](v1::Hello& h) { h.mutable_exits(0)->set_signal(0); }),
              HasSubstr("exits: signal is 0"));
  EXPECT_THAT(refusal([](v1::Hello& h) { h.mutable_exits(0)->set_signal(65); }), HasSubstr("signal is 65"));
  EXPECT_THAT(refusal([](v1::Hello& h) { h.mutable_exits(0)->set_boot_id(""); }), HasSubstr("boot_id"));
  EXPECT_THAT(refusal([](v1::Hello& h) { h.mutable_exits(0)->set_log_tail(std::string(20'000, 'a')); }),
              HasSubstr("log_tail has 20000 bytes"));
  EXPECT_THAT(refusal([](v1::Hello& h) { h.mutable_exits(0)->set_log_tail("\x1b[31m"); }),
              HasSubstr("control characters"));
  EXPECT_THAT(refusal([](v1::Hello& h) {
                for (int i = 0; i < 5000; ++i) h.mutable_exits(0)->add_tiles();
              }),
              HasSubstr("tiles has 5001 entries"));
  EXPECT_THAT(refusal([](v1::Hello& h) {
                for (int i = 0; i < 4; ++i) *h.add_exits() = h.exits(0);
              }),
              HasSubstr("exits: has 5 entries"));
}

}  // namespace
}  // namespace shutterline::server
