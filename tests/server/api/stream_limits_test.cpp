// Streams that say nothing, too many of them, and messages that are larger than they look.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "proto/convert/job_spec.h"
#include "shutterline/v1/workers.grpc.pb.h"
#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"
#include "tests/support/fake_clock.h"

namespace shutterline::test {
namespace {

using testing::HasSubstr;
using Code = grpc::StatusCode;

class StreamLimitsTest : public CoordinatorFixture {
 protected:
  StreamLimitsTest() {
    config_.streams.max_sessions = 3;
    config_.streams.max_watches = 2;
    config_.streams.max_uploads = 2;
    config_.streams.max_uploading_bytes = 1000;
    StopCoordinator();
    auto coordinator = server::Coordinator::Start(config_, clock_);
    EXPECT_TRUE(coordinator.ok()) << coordinator.status();
    coordinator_ = *std::move(coordinator);
    channel_ = coordinator_->InProcessChannel();
    jobs_ = v1::Jobs::NewStub(channel_);
    blobs_ = v1::Blobs::NewStub(channel_);
    workers_ = v1::Workers::NewStub(channel_);
  }
  ~StreamLimitsTest() override { workers_.reset(); }

  v1::BlobChunk Chunk(const std::string& content, uint64_t size, uint64_t offset, const std::string& data) {
    v1::BlobChunk chunk;
    *chunk.mutable_digest() = convert::ToProto(Sha256(content));
    chunk.set_size_bytes(size);
    chunk.set_offset(offset);
    chunk.set_data(data);
    return chunk;
  }

  /// Deadlines begin when the coordinator gets to it, which nobody tells us: so time passes until `work` is
  /// done.
  template <typename Work>
  void WhileTimePasses(const Work& work) {
    std::atomic<bool> done = false;
    std::thread time([&] {
      while (!done) {
        clock_.Advance(absl::Seconds(5));
        std::this_thread::yield();
      }
    });
    work();
    done = true;
    time.join();
  }

  FakeClock clock_;
  std::unique_ptr<v1::Workers::Stub> workers_;
};

TEST_F(StreamLimitsTest, AStreamThatDoesNotSayWhoItIsEnds) {
  grpc::ClientContext session_context, results_context;
  const auto session = workers_->Session(&session_context);
  const auto results = workers_->PushResults(&results_context);
  grpc::Status session_status, results_status;
  WhileTimePasses([&] {
    session_status = session->Finish();
    results_status = results->Finish();
  });
  EXPECT_EQ(session_status.error_code(), Code::DEADLINE_EXCEEDED);
  EXPECT_THAT(session_status.error_message(), HasSubstr("open: did not come in time"));
  EXPECT_EQ(results_status.error_code(), Code::DEADLINE_EXCEEDED);
  EXPECT_THAT(results_status.error_message(), HasSubstr("first batch"));
}

TEST_F(StreamLimitsTest, AnIntroductionIsEnoughAndIsNotAcknowledged) {
  FakeWorker worker(channel_);
  grpc::ClientContext context;
  const auto results = workers_->PushResults(&context);
  v1::ResultBatch introduction;
  introduction.set_session_id(worker.welcome().session_id());
  introduction.set_epoch(worker.welcome().epoch());
  ASSERT_TRUE(results->Write(introduction));
  // A batch that is answered, so that the introduction has been read.
  v1::ResultBatch batch;
  batch.set_batch_id(7);
  batch.add_tiles()->mutable_failure()->set_code(13);
  ASSERT_TRUE(results->Write(batch));
  v1::ResultAck ack;
  ASSERT_TRUE(results->Read(&ack));
  EXPECT_EQ(ack.batch_id(), 7u);
  // Deadlines pass, as a stream beside it shows.
  grpc::ClientContext silent_context;
  const auto silent = workers_->PushResults(&silent_context);
  WhileTimePasses([&] { EXPECT_EQ(silent->Finish().error_code(), Code::DEADLINE_EXCEEDED); });
  batch.set_batch_id(8);
  ASSERT_TRUE(results->Write(batch));
  ASSERT_TRUE(results->Read(&ack)) << "the stream has ended though it had said who it was";
  EXPECT_EQ(ack.batch_id(), 8u);
}

TEST_F(StreamLimitsTest, AWriterThatStallsEndsAndTheNextOneGoesOn) {
  const std::string content(600, 'x');
  {
    grpc::ClientContext context;
    v1::Committed committed;
    const auto writer = blobs_->Write(&context, &committed);
    ASSERT_TRUE(writer->Write(Chunk(content, 600, 0, content.substr(0, 100))));
    // Stored, so the coordinator waits for more.
    while (true) {
      grpc::ClientContext query_context;
      v1::Committed here;
      ASSERT_TRUE(blobs_->QueryWrite(&query_context, convert::ToProto(Sha256(content)), &here).ok());
      if (here.size_bytes() == 100) break;
    }
    grpc::Status status;
    WhileTimePasses([&] { status = writer->Finish(); });
    EXPECT_EQ(status.error_code(), Code::DEADLINE_EXCEEDED) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr("no chunk came for 1m"));
  }
  v1::Committed committed;
  EXPECT_TRUE(Write(Sha256(content), content, 100, 600, committed).ok());
  EXPECT_TRUE(committed.complete());
}

TEST_F(StreamLimitsTest, MoreStreamsThanAllowedAreRefusedAndNoMoreIsLost) {
  v1::Job job = SubmitOrDie(TriangleJob(0, 0, 32, 32));
  v1::WatchRequest request;
  request.set_job_id(job.id());
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::JobEvent>>> watches;
  v1::JobEvent event;
  for (int i = 0; i < 2; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    watches.push_back(jobs_->Watch(contexts.back().get(), request));
    ASSERT_TRUE(watches.back()->Read(&event));
  }
  {
    grpc::ClientContext context;
    const auto third = jobs_->Watch(&context, request);
    EXPECT_FALSE(third->Read(&event));
    const grpc::Status status = third->Finish();
    EXPECT_EQ(status.error_code(), Code::RESOURCE_EXHAUSTED);
    EXPECT_THAT(status.error_message(), HasSubstr("2 Watch and ReadTiles streams are open"));
  }
  contexts[0]->TryCancel();
  EXPECT_EQ(watches[0]->Finish().error_code(), Code::CANCELLED);
  // Its place comes free once the coordinator has noticed.
  bool served = false;
  for (int i = 0; i < 10'000 && !served; ++i) {
    grpc::ClientContext context;
    const auto next = jobs_->Watch(&context, request);
    served = next->Read(&event);
    context.TryCancel();
    next->Finish();
  }
  EXPECT_TRUE(served);
}

TEST_F(StreamLimitsTest, UploadsShareAQuotaOfBytes) {
  grpc::ClientContext first_context;
  v1::Committed first_committed;
  const std::string a(800, 'a'), b(201, 'b'), c(200, 'c');
  const auto first = blobs_->Write(&first_context, &first_committed);
  ASSERT_TRUE(first->Write(Chunk(a, 800, 0, a.substr(0, 10))));
  while (true) {
    grpc::ClientContext context;
    v1::Committed here;
    ASSERT_TRUE(blobs_->QueryWrite(&context, convert::ToProto(Sha256(a)), &here).ok());
    if (here.size_bytes() == 10) break;
  }
  v1::Committed committed;
  const grpc::Status refused = Write(Sha256(b), b, 0, 201, committed);
  EXPECT_EQ(refused.error_code(), Code::RESOURCE_EXHAUSTED);
  EXPECT_THAT(refused.error_message(),
              HasSubstr("1000 bytes together, of which 800 are taken; this one has 201"));
  EXPECT_TRUE(Write(Sha256(c), c, 0, 200, committed).ok());
  ASSERT_TRUE(first->Write(Chunk(a, 800, 10, a.substr(10))));
  first->WritesDone();
  EXPECT_TRUE(first->Finish().ok());
  EXPECT_TRUE(Write(Sha256(b), b, 0, 201, committed).ok());
}

TEST_F(StreamLimitsTest, AnUploadThatHasEndedIsNoLongerInTheWayOfTheNext) {
  for (int i = 0; i < 200; ++i) {
    const std::string all = absl::StrFormat("%01000d", i);  // The whole quota.
    v1::Committed committed;
    const grpc::Status status = Write(Sha256(all), all, 0, all.size(), committed);
    ASSERT_TRUE(status.ok()) << i << ": " << status.error_message();
  }
}

TEST_F(StreamLimitsTest, MessagesThatUnfoldAreRefusedUnread) {
  FakeWorker worker(channel_);
  grpc::ClientContext context;
  const auto results = workers_->PushResults(&context);
  v1::ResultBatch batch;
  batch.set_session_id(worker.welcome().session_id());
  batch.set_epoch(worker.welcome().epoch());
  for (int i = 0; i < 250'000; ++i) batch.add_tiles();  // Half a megabyte on the wire.
  results->Write(batch);
  v1::ResultAck ack;
  EXPECT_FALSE(results->Read(&ack));
  const grpc::Status status = results->Finish();
  EXPECT_EQ(status.error_code(), Code::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("more fields than any request needs"));
}

}  // namespace
}  // namespace shutterline::test
