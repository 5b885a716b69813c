#include "server/coordinator.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <thread>

#include "common/base/ids.h"
#include "proto/convert/job_spec.h"
#include "proto/convert/status.h"
#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::server {
namespace {

using test::CoordinatorFixture;
using test::FakeWorker;
using testing::HasSubstr;

class CoordinatorTest : public CoordinatorFixture {};

TEST_F(CoordinatorTest, TwoWorkersRenderAJobToFetchedFrames) {
  const v1::Job job = SubmitOrDie(TriangleJob(1, 3, 100, 70));
  EXPECT_EQ(job.state(), v1::JOB_STATE_QUEUED);  // Without a worker a job waits.
  EXPECT_EQ(job.tiles_total(), 3u * 4 * 3);
  FakeWorker a(channel_, "a"), b(channel_, "b");
  std::thread other([&] { b.RenderUntilForgotten(); });
  a.RenderUntilForgotten();
  other.join();
  std::vector<v1::JobEvent> events;
  const v1::Job ended = WaitForEnd(job.id(), &events);
  EXPECT_EQ(ended.state(), v1::JOB_STATE_SUCCEEDED) << ended.error();
  EXPECT_EQ(ended.frames_finished(), 3u);
  EXPECT_EQ(ended.tiles_done(), 36u);
  for (int frame = 1; frame <= 3; ++frame) ExpectSyntheticFrame(job.id(), frame, 100, 70);
  for (size_t i = 1; i < events.size(); ++i) EXPECT_GT(events[i].seq(), events[i - 1].seq());
  // Who has seen it all is told nothing more; who has seen the half is told the rest.
  std::vector<v1::JobEvent> rest;
  WaitForEnd(job.id(), &rest, events.back().seq());
  EXPECT_TRUE(rest.empty());
  WaitForEnd(job.id(), &rest, events[1].seq());
  EXPECT_EQ(rest.size(), events.size() - 2);
}

TEST_F(CoordinatorTest, CreditThatComesWithResultsIsCreditAndWorkersHearHowLongToGather) {
  SubmitOrDie(TriangleJob(0, 9, 320, 320));
  FakeWorker worker(channel_);
  EXPECT_TRUE(worker.welcome().credit_with_results());
  EXPECT_EQ(convert::FromProto(worker.welcome().gather()), absl::Milliseconds(5));
  worker.Credit(1);
  v1::Grant grant = worker.NextGrant();
  for (int i = 0; i < 3; ++i) {
    const v1::ResultAck ack = worker.Render(grant, 1);
    ASSERT_TRUE(ack.has_gather());
    EXPECT_EQ(convert::FromProto(ack.gather()), absl::Milliseconds(5)) << "one worker need not wait";
    const v1::Grant next = worker.NextGrant();
    EXPECT_NE(next.lease_id(), grant.lease_id());
    grant = next;
  }
  // More than anybody can want does not run over.
  for (int i = 0; i < 3; ++i) worker.Render(grant, std::numeric_limits<uint32_t>::max());
  worker.NextGrant();
}

TEST_F(CoordinatorTest, FetchResumesAtAnOffset) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 200, 200));
  std::string bytes, tail;
  v1::FrameChunk first;
  EXPECT_EQ(Fetch(job.id(), 0, 0, bytes, first).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(Fetch(job.id(), 1, 0, bytes, first).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Fetch(MakeUuid(), 0, 0, bytes, first).error_code(), grpc::StatusCode::NOT_FOUND);
  FakeWorker worker(channel_);
  worker.RenderUntilForgotten();
  ASSERT_TRUE(Fetch(job.id(), 0, 0, bytes, first).ok());
  ASSERT_TRUE(Fetch(job.id(), 0, 777, tail, first).ok());
  EXPECT_EQ(tail, bytes.substr(777));
  std::string nothing;
  EXPECT_TRUE(Fetch(job.id(), 0, bytes.size(), nothing, first).ok());
  EXPECT_EQ(nothing, "");
  EXPECT_EQ(Fetch(job.id(), 0, bytes.size() + 1, nothing, first).error_code(),
            grpc::StatusCode::OUT_OF_RANGE);
}

TEST_F(CoordinatorTest, RequestIdMakesSubmitSafeToRepeat) {
  v1::SubmitRequest request = TriangleJob(0, 1, 64, 64);
  const v1::Job job = SubmitOrDie(request);
  EXPECT_EQ(SubmitOrDie(request).id(), job.id());
  v1::SubmitRequest other = request;
  other.mutable_spec()->mutable_render()->set_spp(7);
  v1::Job refused;
  EXPECT_EQ(Submit(other, refused).error_code(), grpc::StatusCode::ALREADY_EXISTS);
  StopCoordinator();
  StartCoordinator();
  EXPECT_EQ(SubmitOrDie(request).id(), job.id());
  EXPECT_EQ(Submit(other, refused).error_code(), grpc::StatusCode::ALREADY_EXISTS);
  request.clear_request_id();
  EXPECT_EQ(Submit(request, refused).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(CoordinatorTest, DeadWorkersTilesGoToAnother) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 64, 64));
  FakeWorker dying(channel_, "dying");
  dying.Credit(3);
  for (int i = 0; i < 3; ++i) dying.NextGrant();
  dying.Die();
  FakeWorker heir(channel_, "heir");
  heir.RenderUntilForgotten();
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
  ExpectSyntheticFrame(job.id(), 0, 64, 64);
}

TEST_F(CoordinatorTest, WorkerThatLeavesInOrderGivesItsLeasesBackAtOnce) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 64, 32));
  FakeWorker leaving(channel_, "leaving");
  leaving.Credit(2);
  leaving.NextGrant();
  leaving.NextGrant();
  const auto [session, results] = leaving.Leave();
  EXPECT_TRUE(session.ok()) << session.error_message();
  EXPECT_TRUE(results.ok()) << results.error_message();
  FakeWorker heir(channel_, "heir");
  heir.RenderUntilForgotten();
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
}

TEST_F(CoordinatorTest, DuplicatesAndMismatchesKeepTheFirstPixels) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 64, 32));  // 2 tiles.
  FakeWorker worker(channel_);
  worker.Credit(1);
  const v1::Grant grant = worker.NextGrant();
  ASSERT_EQ(grant.tiles_size(), 1);
  const v1::TileResult result = worker.Result(grant, grant.tiles(0));
  v1::TileResult other = result;
  (*other.mutable_pixels())[0] ^= 1;
  // Twice in one batch as well as in a later one.
  const v1::ResultAck first = worker.Push({result, result, other});
  EXPECT_THAT(first.outcomes(),
              testing::ElementsAre(v1::ResultAck::OUTCOME_STORED, v1::ResultAck::OUTCOME_DUPLICATE,
                                   v1::ResultAck::OUTCOME_MISMATCH));
  EXPECT_THAT(worker.Push({other, result}).outcomes(),
              testing::ElementsAre(v1::ResultAck::OUTCOME_MISMATCH, v1::ResultAck::OUTCOME_DUPLICATE));
  EXPECT_EQ(Get(job.id()).mismatched_tiles(), 2u);
  EXPECT_EQ(Get(job.id()).tiles_done(), 1u);
  worker.RenderUntilForgotten();
  ExpectSyntheticFrame(job.id(), 0, 64, 32);
}

TEST_F(CoordinatorTest, CancelRevokesLeasesAndIsDurable) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 9, 64, 64));
  FakeWorker worker(channel_);
  worker.Credit(1);
  const v1::Grant grant = worker.NextGrant();
  v1::Job cancelled;
  ASSERT_TRUE(Cancel(job.id(), cancelled).ok());
  EXPECT_EQ(cancelled.state(), v1::JOB_STATE_CANCELLED);
  v1::CoordinatorMessage message;
  ASSERT_TRUE(worker.Next(message));
  ASSERT_TRUE(message.has_revoke());
  EXPECT_EQ(message.revoke().lease_ids(0), grant.lease_id());
  ASSERT_TRUE(worker.Next(message));
  EXPECT_EQ(message.forget_job().job_id(), job.id());
  EXPECT_THAT(worker.Render(grant).outcomes(), testing::Each(v1::ResultAck::OUTCOME_UNWANTED));
  EXPECT_TRUE(Cancel(job.id(), cancelled).ok());  // Again: nothing changes.
  worker.Die();
  StopCoordinator();
  StartCoordinator();
  EXPECT_EQ(Get(job.id()).state(), v1::JOB_STATE_CANCELLED);
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_CANCELLED);
}

TEST_F(CoordinatorTest, TileThatFailsThreeTimesFailsTheJobWithItsReason) {
  const v1::Job job = SubmitOrDie(TriangleJob(4, 4, 32, 32));
  FakeWorker worker(channel_);
  for (int i = 0; i < 3; ++i) {
    worker.Credit(1);
    const v1::Grant grant = worker.NextGrant();
    v1::TileResult result = worker.Result(grant, 0);
    result.mutable_failure()->set_code(8);
    result.mutable_failure()->set_message("too many triangles");
    worker.Push({result});
  }
  const v1::Job failed = WaitForEnd(job.id());
  EXPECT_EQ(failed.state(), v1::JOB_STATE_FAILED);
  EXPECT_THAT(failed.error(), HasSubstr("frame 4, tile 0: RESOURCE_EXHAUSTED: too many triangles"));
}

TEST_F(CoordinatorTest, SecondStreamTakesTheSessionOver) {
  FakeWorker worker(channel_);
  const auto stub = v1::Workers::NewStub(channel_);
  grpc::ClientContext context;
  const auto session = stub->Session(&context);
  v1::WorkerMessage message;
  message.mutable_open()->set_epoch(worker.welcome().epoch());
  message.mutable_open()->set_session_id(worker.welcome().session_id());
  session->Write(message);
  EXPECT_EQ(worker.SessionStatus().error_code(), grpc::StatusCode::ABORTED);
  SubmitOrDie(TriangleJob(0, 0, 32, 32));
  message.mutable_credit()->set_leases(1);
  session->Write(message);
  v1::CoordinatorMessage granted;
  ASSERT_TRUE(session->Read(&granted));
  EXPECT_TRUE(granted.has_job());
  context.TryCancel();
  session->Finish();
}

TEST_F(CoordinatorTest, BlobWritesResumeAndDamageIsNoticed) {
  std::string content;
  for (int i = 0; i < 200'000; ++i) content.push_back(char(i * 7 + i / 1000));
  const Digest digest = Sha256(content);
  v1::Committed committed;
  ASSERT_TRUE(Write(digest, content, 0, 50'000, committed).ok());
  EXPECT_FALSE(committed.complete());
  EXPECT_EQ(committed.size_bytes(), 50'000u);
  EXPECT_EQ(Write(digest, content, 60'000, 61'000, committed).error_code(), grpc::StatusCode::OUT_OF_RANGE);
  StopCoordinator();
  StartCoordinator();
  ASSERT_TRUE(Write(digest, content, 50'000, content.size(), committed).ok());
  EXPECT_TRUE(committed.complete());
  std::string wrong = content;
  wrong[100'000] ^= 1;
  const Digest unseen = Sha256("unseen");
  EXPECT_EQ(Write(unseen, wrong, 0, wrong.size(), committed).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);

  const auto read = [&](std::string& bytes) {
    grpc::ClientContext context;
    v1::ReadRequest request;
    *request.mutable_digest() = convert::ToProto(digest);
    const auto reader = blobs_->Read(&context, request);
    v1::BlobChunk chunk;
    while (reader->Read(&chunk)) bytes += chunk.data();
    return reader->Finish();
  };
  std::string bytes;
  ASSERT_TRUE(read(bytes).ok());
  EXPECT_EQ(bytes, content);

  const std::string hex = digest.ToHex();
  const std::string path = absl::StrCat(config_.data_dir, "/assets/blobs/", hex.substr(0, 2), "/", hex);
  std::filesystem::resize_file(path, 199'999);
  EXPECT_EQ(read(bytes).error_code(), grpc::StatusCode::DATA_LOSS);
  grpc::ClientContext context;
  v1::DigestList list, missing;
  *list.add_digests() = convert::ToProto(digest);
  *list.add_digests() = convert::ToProto(digest);
  ASSERT_TRUE(blobs_->FindMissing(&context, list, &missing).ok());
  EXPECT_EQ(missing.digests_size(), 1);  // It can be uploaded again.
  ASSERT_TRUE(Write(digest, content, 0, content.size(), committed).ok());
  EXPECT_TRUE(committed.complete());
}

TEST_F(CoordinatorTest, ListsJobsInPagesAndWorkers) {
  std::vector<std::string> ids;
  for (int i = 0; i < 5; ++i) ids.insert(ids.begin(), SubmitOrDie(TriangleJob(i, i, 32, 32)).id());
  std::vector<std::string> listed;
  v1::ListRequest request;
  request.set_page_size(2);
  do {
    grpc::ClientContext context;
    v1::ListResponse response;
    ASSERT_TRUE(jobs_->List(&context, request, &response).ok());
    EXPECT_LE(response.jobs_size(), 2);
    for (const v1::Job& job : response.jobs()) listed.push_back(job.id());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_EQ(listed, ids);
  FakeWorker worker(channel_, "seen");
  worker.Credit(1);
  worker.NextGrant();
  grpc::ClientContext context;
  v1::ListWorkersResponse workers;
  ASSERT_TRUE(jobs_->ListWorkers(&context, {}, &workers).ok());
  ASSERT_EQ(workers.workers_size(), 1);
  EXPECT_EQ(workers.workers(0).uuid(), "seen");
  EXPECT_EQ(workers.workers(0).leased_tiles(), 1u);
}

TEST_F(CoordinatorTest, FolderBelongsToOneCoordinator) {
  const auto second = Coordinator::Start(config_);
  EXPECT_TRUE(absl::IsFailedPrecondition(second.status())) << second.status();
}

TEST(CoordinatorConfigTest, ListensToOthersOnlyWhenTold) {
  Config config;
  config.data_dir = "/tmp/unused";
  for (const char* open :
       {"0.0.0.0:1", "[::]:1", "192.168.0.1:1", "127.evil.example:1", "host:70000", "host"}) {
    config.listen = open;
    EXPECT_TRUE(absl::IsInvalidArgument(Validate(config))) << open;
  }
  for (const char* closed : {"127.0.0.1:0", "localhost:1", "[::1]:1", ""}) {
    config.listen = closed;
    EXPECT_TRUE(Validate(config).ok()) << closed;
  }
  config.listen = "0.0.0.0:1";
  config.insecure_listen = true;
  EXPECT_TRUE(Validate(config).ok());
}

}  // namespace
}  // namespace shutterline::server
