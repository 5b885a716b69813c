#include "tests/integration/recording_client.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <utility>

#include "common/base/ids.h"
#include "tests/server/fake_worker.h"

namespace shutterline {
namespace {

void SetDeadline(grpc::ClientContext& context) {
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(10));
}

/// A registered worker with both streams.
struct Connection {
  grpc::ClientContext session_context, results_context;
  v1::Welcome welcome;
  std::unique_ptr<grpc::ClientReaderWriter<v1::WorkerMessage, v1::CoordinatorMessage>> session;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ResultBatch, v1::ResultAck>> results;
  uint64_t batches = 0;

  bool Open(v1::Workers::Stub& stub) {
    grpc::ClientContext context;
    SetDeadline(context);
    if (!stub.Register(&context, test::FakeWorker::MakeHello(MakeUuid()), &welcome).ok()) return false;
    session = stub.Session(&session_context);
    results = stub.PushResults(&results_context);
    v1::WorkerMessage open;
    open.mutable_open()->set_session_id(welcome.session_id());
    open.mutable_open()->set_epoch(welcome.epoch());
    return session->Write(open);
  }
  bool Credit(uint32_t leases) {
    v1::WorkerMessage message;
    message.mutable_credit()->set_leases(leases);
    return session->Write(message);
  }
  bool Push(v1::ResultBatch& batch, v1::ResultAck& ack) {
    batch.set_session_id(welcome.session_id());
    batch.set_epoch(welcome.epoch());
    batch.set_batch_id(++batches);
    return results->Write(batch) && results->Read(&ack) && ack.outcomes_size() == batch.tiles_size();
  }
  ~Connection() {
    if (session == nullptr) return;
    session_context.TryCancel();
    results_context.TryCancel();
    session->Finish();
    results->Finish();
  }
};

}  // namespace

RecordingClient::RecordingClient(std::string address, v1::JobSpec spec, size_t most_jobs)
    : address_(std::move(address)), spec_(std::move(spec)), most_jobs_(most_jobs) {
  submitter_ = std::thread([this] { Submit(); });
  worker_ = std::thread([this] { Render(); });
}

RecordingClient::~RecordingClient() {
  Stop();
}

void RecordingClient::Stop() {
  stopping_ = true;
  if (submitter_.joinable()) submitter_.join();
  if (worker_.joinable()) worker_.join();
}

std::shared_ptr<grpc::Channel> RecordingClient::Dial() const {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address_, grpc::InsecureChannelCredentials(), arguments);
}

std::set<std::string> RecordingClient::AcknowledgedJobs() const {
  absl::MutexLock lock(&mutex_);
  return jobs_;
}

std::set<RecordingClient::Tile> RecordingClient::AcknowledgedTiles() const {
  absl::MutexLock lock(&mutex_);
  return tiles_;
}

void RecordingClient::Submit() {
  while (!stopping_) {
    // A channel each time, as a new client: none remembers that the coordinator was down.
    const auto stub = v1::Jobs::NewStub(Dial());
    while (!stopping_ && submitting_) {
      grpc::ClientContext context;
      SetDeadline(context);
      v1::SubmitRequest request;
      request.set_request_id(MakeUuid());
      *request.mutable_spec() = spec_;
      v1::Job job;
      if (!stub->Submit(&context, request, &job).ok()) break;
      absl::MutexLock lock(&mutex_);
      jobs_.insert(job.id());
      if (jobs_.size() == most_jobs_) submitting_ = false;
    }
    absl::SleepFor(absl::Milliseconds(5));
  }
}

v1::TileResult RecordingClient::ResultOf(const Tile& tile) const {
  const auto& [job, frame, number] = tile;
  v1::TileResult result;
  result.set_job_id(job);
  result.set_frame(frame);
  result.set_tile(number);
  result.mutable_render_time()->set_nanos(1'000'000);
  result.set_pixels(test::SyntheticTile(spec_.render().width(), spec_.render().height(), frame, number));
  return result;
}

void RecordingClient::Serve(v1::Workers::Stub& stub) {
  Connection connection;
  if (!connection.Open(stub) || !connection.Credit(4)) return;
  v1::CoordinatorMessage message;
  while (!stopping_ && connection.session->Read(&message)) {
    if (!message.has_grant()) continue;
    v1::ResultBatch batch;
    std::vector<Tile> tiles;
    for (const uint32_t tile : message.grant().tiles()) {
      tiles.emplace_back(message.grant().job_id(), message.grant().frame(), tile);
      *batch.add_tiles() = ResultOf(tiles.back());
    }
    v1::ResultAck ack;
    if (!connection.Push(batch, ack)) return;
    {
      absl::MutexLock lock(&mutex_);
      for (int i = 0; i < ack.outcomes_size(); ++i) {
        if (ack.outcomes(i) == v1::ResultAck::OUTCOME_STORED) tiles_.insert(tiles[size_t(i)]);
      }
    }
    if (!connection.Credit(1)) return;
  }
}

void RecordingClient::Render() {
  while (!stopping_) {
    const auto stub = v1::Workers::NewStub(Dial());
    Serve(*stub);
    absl::SleepFor(absl::Milliseconds(5));
  }
}

std::set<RecordingClient::Tile> RecordingClient::Unknown(const std::set<Tile>& tiles) const {
  const auto stub = v1::Workers::NewStub(Dial());
  Connection connection;
  std::set<Tile> unknown = tiles;
  if (!connection.Open(*stub)) return unknown;
  for (auto tile = tiles.begin(); tile != tiles.end();) {
    v1::ResultBatch batch;
    std::vector<Tile> sent;
    for (; tile != tiles.end() && sent.size() < 32; ++tile) {
      sent.push_back(*tile);
      *batch.add_tiles() = ResultOf(*tile);
    }
    v1::ResultAck ack;
    if (!connection.Push(batch, ack)) return unknown;
    for (int i = 0; i < ack.outcomes_size(); ++i) {
      // A duplicate of what is there, or of a frame that has been written by now.
      if (ack.outcomes(i) == v1::ResultAck::OUTCOME_DUPLICATE ||
          ack.outcomes(i) == v1::ResultAck::OUTCOME_UNWANTED) {
        unknown.erase(sent[size_t(i)]);
      }
    }
  }
  return unknown;
}

}  // namespace shutterline
