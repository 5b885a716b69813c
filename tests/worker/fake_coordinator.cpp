#include "tests/worker/fake_coordinator.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "proto/convert/job_spec.h"
#include "proto/convert/status.h"

namespace shutterline::worker {

FakeCoordinator::FakeCoordinator() {
  grpc::ServerBuilder builder;
  builder.RegisterService(static_cast<v1::Workers::Service*>(this));
  builder.RegisterService(static_cast<v1::Blobs::Service*>(this));
  server_ = builder.BuildAndStart();
}

FakeCoordinator::~FakeCoordinator() {
  BreakStreams();
  server_->Shutdown(std::chrono::system_clock::now());
}

std::shared_ptr<grpc::Channel> FakeCoordinator::Channel() {
  return server_->InProcessChannel({});
}

void FakeCoordinator::AnswerRegister(std::function<grpc::Status(const v1::Hello&)> answer) {
  absl::MutexLock lock(&mutex_);
  answer_register_ = std::move(answer);
}

void FakeCoordinator::AnswerOpen(std::function<grpc::Status(const v1::Open&)> answer) {
  absl::MutexLock lock(&mutex_);
  answer_open_ = std::move(answer);
}

void FakeCoordinator::Acknowledge(bool on) {
  absl::MutexLock lock(&mutex_);
  acknowledge_ = on;
}

void FakeCoordinator::SetOutcome(v1::ResultAck::Outcome outcome) {
  absl::MutexLock lock(&mutex_);
  outcome_ = outcome;
}

void FakeCoordinator::SetHeartbeatInterval(absl::Duration interval) {
  absl::MutexLock lock(&mutex_);
  heartbeat_interval_ = interval;
}

void FakeCoordinator::SetGather(absl::Duration gather) {
  absl::MutexLock lock(&mutex_);
  gather_ = gather;
}

void FakeCoordinator::SetGatherOfAcks(absl::Duration gather) {
  absl::MutexLock lock(&mutex_);
  ack_gather_ = gather;
}

Digest FakeCoordinator::PutBlob(const std::string& bytes) {
  const Digest digest = Sha256(bytes);
  absl::MutexLock lock(&mutex_);
  blobs_[convert::ToProto(digest).sha256()] = bytes;
  return digest;
}

void FakeCoordinator::Send(const v1::CoordinatorMessage& message) {
  absl::MutexLock lock(&mutex_);
  const auto open = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return current_ != nullptr; };
  ASSERT_TRUE(mutex_.AwaitWithTimeout(absl::Condition(&open), absl::Minutes(1)));
  current_->Write(message);
}

void FakeCoordinator::SendJob(const std::string& id, int width, int height, const Digest& scene) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  v1::CoordinatorMessage message;
  v1::JobDetails& job = *message.mutable_job();
  job.set_job_id(id);
  *job.mutable_scene() = convert::ToProto(SceneManifest{"scene.gltf", {{"scene.gltf", scene, 1}}});
  *job.mutable_render() = convert::ToProto(settings);
  Send(message);
}

void FakeCoordinator::Grant(uint64_t lease, const std::string& job, int frame,
                            const std::vector<uint32_t>& tiles, bool send_at_once) {
  v1::CoordinatorMessage message;
  v1::Grant& grant = *message.mutable_grant();
  grant.set_lease_id(lease);
  grant.set_job_id(job);
  grant.set_frame(frame);
  grant.mutable_tiles()->Add(tiles.begin(), tiles.end());
  grant.set_send_at_once(send_at_once);
  Send(message);
}

void FakeCoordinator::BreakStreams() {
  absl::MutexLock lock(&mutex_);
  current_ = nullptr;
  for (grpc::ServerContext* context : streams_) context->TryCancel();
}

FakeCoordinator::State FakeCoordinator::WaitFor(const std::function<bool(const State&)>& done) {
  absl::MutexLock lock(&mutex_);
  const auto holds = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return done(state_); };
  EXPECT_TRUE(mutex_.AwaitWithTimeout(absl::Condition(&holds), absl::Minutes(1)))
      << "waited in vain; results=" << state_.results.size() << " sessions=" << state_.sessions
      << " heartbeats=" << state_.heartbeats.size() << " credit=" << state_.credit;
  return state_;
}

FakeCoordinator::State FakeCoordinator::state() {
  absl::MutexLock lock(&mutex_);
  return state_;
}

grpc::Status FakeCoordinator::Register(grpc::ServerContext*, const v1::Hello* hello, v1::Welcome* welcome) {
  absl::MutexLock lock(&mutex_);
  state_.hellos.push_back(*hello);
  if (answer_register_) {
    if (grpc::Status status = answer_register_(*hello); !status.ok()) return status;
  }
  welcome->set_epoch(++epoch_);
  welcome->set_session_id(absl::StrCat("session-", epoch_));
  welcome->set_protocol(1);
  *welcome->mutable_lease_ttl() = convert::ToProto(absl::Seconds(15));
  *welcome->mutable_heartbeat_interval() = convert::ToProto(heartbeat_interval_);
  welcome->set_max_batch_bytes(1 << 20);
  if (gather_) {
    *welcome->mutable_gather() = convert::ToProto(*gather_);
    welcome->set_credit_with_results(true);
  }
  return grpc::Status::OK;
}

grpc::Status FakeCoordinator::Session(
    grpc::ServerContext* context,
    grpc::ServerReaderWriter<v1::CoordinatorMessage, v1::WorkerMessage>* stream) {
  v1::WorkerMessage message;
  if (!stream->Read(&message) || !message.has_open()) return {grpc::StatusCode::INVALID_ARGUMENT, "no Open"};
  {
    absl::MutexLock lock(&mutex_);
    state_.opens.push_back(message.open());
    ++state_.sessions;
    if (answer_open_) {
      if (grpc::Status status = answer_open_(message.open()); !status.ok()) return status;
    }
    state_.credit = 0;
    ++state_.sessions_open;
    streams_.push_back(context);
    current_ = stream;
  }
  while (stream->Read(&message)) {
    absl::MutexLock lock(&mutex_);
    if (message.has_credit()) state_.credit += message.credit().leases();
    if (message.has_draining()) ++state_.draining;
    if (message.has_heartbeat()) {
      const auto& ids = message.heartbeat().lease_ids();
      state_.heartbeats.emplace_back(ids.begin(), ids.end());
    }
    if (message.has_return_leases()) {
      const auto& ids = message.return_leases().lease_ids();
      state_.returned.insert(state_.returned.end(), ids.begin(), ids.end());
    }
  }
  absl::MutexLock lock(&mutex_);
  if (current_ == stream) current_ = nullptr;
  --state_.sessions_open;
  std::erase(streams_, context);
  return grpc::Status::OK;
}

grpc::Status FakeCoordinator::PushResults(grpc::ServerContext* context,
                                          grpc::ServerReaderWriter<v1::ResultAck, v1::ResultBatch>* stream) {
  {
    absl::MutexLock lock(&mutex_);
    streams_.push_back(context);
  }
  v1::ResultBatch batch;
  while (stream->Read(&batch)) {
    if (batch.tiles().empty()) continue;  // An introduction.
    v1::ResultAck ack;
    bool acknowledge = false;
    {
      absl::MutexLock lock(&mutex_);
      acknowledge = acknowledge_;
      ack.set_batch_id(batch.batch_id());
      if (ack_gather_) *ack.mutable_gather() = convert::ToProto(*ack_gather_);
      state_.batches.push_back(batch.tiles_size());
      state_.credit_with_results += batch.credit();
      for (const v1::TileResult& tile : batch.tiles()) {
        state_.results.push_back(tile);
        state_.result_epochs.push_back(batch.epoch());
        ack.add_outcomes(outcome_);
      }
    }
    if (acknowledge) stream->Write(ack);
  }
  absl::MutexLock lock(&mutex_);
  std::erase(streams_, context);
  return grpc::Status::OK;
}

grpc::Status FakeCoordinator::Read(grpc::ServerContext*, const v1::ReadRequest* request,
                                   grpc::ServerWriter<v1::BlobChunk>* writer) {
  std::string bytes;
  {
    absl::MutexLock lock(&mutex_);
    const auto blob = blobs_.find(request->digest().sha256());
    if (blob == blobs_.end()) return {grpc::StatusCode::NOT_FOUND, "no such blob"};
    bytes = blob->second;
  }
  for (size_t offset = request->offset(); offset < bytes.size(); offset += 7) {
    v1::BlobChunk chunk;
    chunk.set_size_bytes(bytes.size());
    chunk.set_offset(offset);
    chunk.set_data(bytes.substr(offset, 7));
    writer->Write(chunk);
  }
  return grpc::Status::OK;
}

}  // namespace shutterline::worker
