// What a coordinator refuses, and what it says of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/build_id.h"
#include "common/base/ids.h"
#include "proto/convert/job_spec.h"
#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::server {
namespace {

using test::CoordinatorFixture;
using test::FakeWorker;
using testing::HasSubstr;

class CoordinatorRefusalTest : public CoordinatorFixture {};

TEST_F(CoordinatorRefusalTest, ResultsThatDoNotFitAreRefused) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 64, 32));
  FakeWorker worker(channel_);
  worker.Credit(1);
  const v1::Grant grant = worker.NextGrant();
  const v1::TileResult good = worker.Result(grant, grant.tiles(0));
  v1::TileResult frame = good, tile = good, size = good, unknown = good;
  frame.set_frame(1);
  tile.set_tile(2);
  size.mutable_pixels()->pop_back();
  unknown.set_job_id("no such job");
  EXPECT_THAT(worker.Push({frame, tile, size, unknown, good}).outcomes(),
              testing::ElementsAre(v1::ResultAck::OUTCOME_REFUSED, v1::ResultAck::OUTCOME_REFUSED,
                                   v1::ResultAck::OUTCOME_REFUSED, v1::ResultAck::OUTCOME_UNWANTED,
                                   v1::ResultAck::OUTCOME_STORED));
}

TEST_F(CoordinatorRefusalTest, SubmitNamesWhatIsWrong) {
  const v1::SubmitRequest good = TriangleJob(0, 0, 64, 64);
  const auto expect = [&](const char* what, grpc::StatusCode code,
                          const std::function<void(v1::JobSpec&)>& change) {
    v1::SubmitRequest request = good;
    request.set_request_id(MakeUuid());
    change(*request.mutable_spec());
    v1::Job job;
    const grpc::Status status = Submit(request, job);
    EXPECT_EQ(status.error_code(), code) << what << ": " << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(what));
  };
  using enum grpc::StatusCode;
  expect("render.pattern", INVALID_ARGUMENT,
         [](v1::JobSpec& s) { s.mutable_render()->set_pattern(v1::Pattern(77)); });
  expect("width", INVALID_ARGUMENT, [](v1::JobSpec& s) { s.mutable_render()->set_width(0); });
  expect("frames.step", INVALID_ARGUMENT, [](v1::JobSpec& s) { s.mutable_frames()->set_step(0); });
  expect("frames", INVALID_ARGUMENT, [](v1::JobSpec& s) {
    s.mutable_frames()->set_first(INT32_MIN);
    s.mutable_frames()->set_last(INT32_MAX);
  });
  expect("..", INVALID_ARGUMENT,
         [](v1::JobSpec& s) { s.mutable_scene()->mutable_files(0)->set_name("../a"); });
  expect("scene.root_name", INVALID_ARGUMENT, [](v1::JobSpec& s) { s.mutable_scene()->set_root_name("b"); });
  expect("size_bytes", INVALID_ARGUMENT,
         [](v1::JobSpec& s) { s.mutable_scene()->mutable_files(0)->set_size_bytes(1); });
  const Digest nowhere = Sha256("nowhere");
  expect(nowhere.ToHex().c_str(), FAILED_PRECONDITION, [&](v1::JobSpec& s) {
    *s.mutable_scene()->mutable_files(0)->mutable_digest() = convert::ToProto(nowhere);
  });
  expect("left", INVALID_ARGUMENT, [](v1::JobSpec& s) { s.mutable_render()->set_camera("left"); });
  const SceneFile broken = Upload("triangle.gltf", "{\"asset\":{\"version\":\"2.0\"},\"meshes\":7}");
  expect("triangle.gltf", INVALID_ARGUMENT, [&](v1::JobSpec& s) {
    *s.mutable_scene()->mutable_files(0)->mutable_digest() = convert::ToProto(broken.digest);
    s.mutable_scene()->mutable_files(0)->set_size_bytes(broken.size);
  });
  SubmitOrDie(good);  // And the coordinator lives.
}

TEST_F(CoordinatorRefusalTest, StrangersAreRefusedByName) {
  const auto stub = v1::Workers::NewStub(channel_);
  v1::Hello build = FakeWorker::MakeHello("x"), protocol = build;
  build.set_build_id("0.0.1+other");
  protocol.mutable_protocol()->set_low(900);
  protocol.mutable_protocol()->set_high(901);
  v1::Welcome welcome;
  grpc::ClientContext first, second;
  const grpc::Status by_build = stub->Register(&first, build, &welcome);
  EXPECT_EQ(by_build.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(by_build.error_message(), testing::AllOf(HasSubstr("0.0.1+other"), HasSubstr(kBuildId)));
  const grpc::Status by_protocol = stub->Register(&second, protocol, &welcome);
  EXPECT_EQ(by_protocol.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(by_protocol.error_message(), HasSubstr("900 to 901"));
}

TEST_F(CoordinatorRefusalTest, StaleEpochAndUnknownSessionAreAborted) {
  const auto stub = v1::Workers::NewStub(channel_);
  FakeWorker worker(channel_);
  for (const bool stale : {true, false}) {
    v1::WorkerMessage open;
    open.mutable_open()->set_epoch(worker.welcome().epoch() - (stale ? 1 : 0));
    open.mutable_open()->set_session_id(stale ? worker.welcome().session_id() : MakeUuid());
    grpc::ClientContext context;
    const auto session = stub->Session(&context);
    session->Write(open);
    v1::CoordinatorMessage message;
    EXPECT_FALSE(session->Read(&message));
    EXPECT_EQ(session->Finish().error_code(), grpc::StatusCode::ABORTED);
    v1::ResultBatch batch;
    batch.set_epoch(open.open().epoch());
    batch.set_session_id(open.open().session_id());
    grpc::ClientContext results_context;
    const auto results = stub->PushResults(&results_context);
    results->Write(batch);
    v1::ResultAck ack;
    EXPECT_FALSE(results->Read(&ack));
    EXPECT_EQ(results->Finish().error_code(), grpc::StatusCode::ABORTED);
  }
}

TEST_F(CoordinatorRefusalTest, ImpossibleStatisticsAreRefusedByNameAndCountForNothing) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 32, 32));
  FakeWorker worker(channel_);
  worker.Credit(1);
  v1::ResultBatch batch;
  batch.set_epoch(worker.welcome().epoch());
  batch.set_session_id(worker.welcome().session_id());
  *batch.add_tiles() = worker.Result(worker.NextGrant(), 0);
  batch.mutable_tiles(0)->mutable_stats()->set_resolve_seconds(std::nan(""));
  const auto stub = v1::Workers::NewStub(channel_);
  grpc::ClientContext context;
  const auto results = stub->PushResults(&context);
  results->Write(batch);
  v1::ResultAck ack;
  EXPECT_FALSE(results->Read(&ack));
  const grpc::Status status = results->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("tile 0 of frame 0: stats.resolve_seconds: is nan"));
  EXPECT_EQ(Get(job.id()).tiles_done(), 0u);
}

}  // namespace
}  // namespace shutterline::server
