#include "tests/server/fake_worker.h"

#include <cstring>

#include "common/base/build_id.h"
#include "common/base/check.h"
#include "common/base/ids.h"
#include "common/job/tile.h"
#include "proto/convert/protocol.h"

namespace shutterline::test {

void SyntheticPixel(int frame, int x, int y, float pixels[4]) {
  pixels[0] = float(x) / 64;
  pixels[1] = float(y) / 64;
  pixels[2] = float(frame) / 16;
  pixels[3] = float((x * 7 + y * 13 + frame) % 32) / 32;
}

std::string SyntheticTile(int width, int height, int frame, uint32_t tile) {
  const TileRect rect = TileGrid{width, height}.Rect(int(tile));
  std::string bytes(size_t(rect.Area()) * 16, '\0');
  for (int y = 0; y < rect.height; ++y) {
    for (int x = 0; x < rect.width; ++x) {
      float pixels[4];
      SyntheticPixel(frame, rect.x + x, rect.y + y, pixels);
      std::memcpy(&bytes[size_t(y * rect.width + x) * 16], pixels, 16);
    }
  }
  return bytes;
}

v1::Hello FakeWorker::MakeHello(const std::string& uuid) {
  v1::Hello hello;
  hello.set_worker_uuid(uuid);
  hello.set_boot_id("the only process of " + uuid);
  hello.mutable_protocol()->set_low(convert::kProtocolLow);
  hello.mutable_protocol()->set_high(convert::kProtocolHigh);
  hello.set_build_id(kBuildId);
  hello.set_isa("fake");
  hello.set_slots(1);
  hello.set_name("fake worker");
  return hello;
}

FakeWorker::FakeWorker(const std::shared_ptr<grpc::Channel>& channel, const std::string& uuid,
                       const std::vector<v1::HeldLease>& held)
    : FakeWorker(channel, MakeHello(uuid), held) {}

FakeWorker::FakeWorker(const std::shared_ptr<grpc::Channel>& channel, const v1::Hello& hello,
                       const std::vector<v1::HeldLease>& held)
    : stub_(v1::Workers::NewStub(channel)) {
  grpc::ClientContext context;
  SL_CHECK(stub_->Register(&context, hello, &welcome_).ok());
  session_ = stub_->Session(&session_context_);
  v1::WorkerMessage message;
  message.mutable_open()->set_session_id(welcome_.session_id());
  message.mutable_open()->set_epoch(welcome_.epoch());
  message.mutable_open()->mutable_held()->Add(held.begin(), held.end());
  SL_CHECK(session_->Write(message));
  results_ = stub_->PushResults(&results_context_);
}

FakeWorker::~FakeWorker() {
  if (!gone_) Die();
}

void FakeWorker::Die() {
  gone_ = true;
  session_context_.TryCancel();
  results_context_.TryCancel();
  session_->Finish();
  results_->Finish();
}

std::pair<grpc::Status, grpc::Status> FakeWorker::Leave() {
  gone_ = true;
  results_->WritesDone();
  const grpc::Status results = results_->Finish();
  session_->WritesDone();
  v1::CoordinatorMessage message;
  while (session_->Read(&message)) {
  }
  return {session_->Finish(), results};
}

grpc::Status FakeWorker::SessionStatus() {
  gone_ = true;
  results_context_.TryCancel();
  results_->Finish();
  v1::CoordinatorMessage message;
  while (session_->Read(&message)) {
  }
  return session_->Finish();
}

void FakeWorker::Credit(uint32_t leases) {
  v1::WorkerMessage message;
  message.mutable_credit()->set_leases(leases);
  session_->Write(message);
}

void FakeWorker::Heartbeat(const std::vector<uint64_t>& leases) {
  v1::WorkerMessage message;
  message.mutable_heartbeat()->mutable_lease_ids()->Add(leases.begin(), leases.end());
  session_->Write(message);
}

void FakeWorker::Return(const std::vector<uint64_t>& leases) {
  v1::WorkerMessage message;
  message.mutable_return_leases()->mutable_lease_ids()->Add(leases.begin(), leases.end());
  session_->Write(message);
}

bool FakeWorker::Next(v1::CoordinatorMessage& message) {
  if (!session_->Read(&message)) return false;
  if (message.has_job()) job = message.job();
  return true;
}

v1::Grant FakeWorker::NextGrant() {
  v1::CoordinatorMessage message;
  while (Next(message)) {
    if (message.has_grant()) return message.grant();
  }
  SL_CHECK(false && "the session ended while a grant was awaited");
  return {};
}

v1::TileResult FakeWorker::Result(const v1::Grant& grant, uint32_t tile) const {
  v1::TileResult result;
  result.set_job_id(grant.job_id());
  result.set_frame(grant.frame());
  result.set_tile(tile);
  result.set_lease_id(grant.lease_id());
  result.set_pixels(SyntheticTile(job.render().width(), job.render().height(), grant.frame(), tile));
  result.mutable_render_time()->set_nanos(1'000'000);
  result.mutable_stats()->set_tiles(1);
  result.mutable_stats()->set_lines(100 + tile);
  result.mutable_stats()->set_shade_seconds(0.25);
  return result;
}

void FakeWorker::FailNext(const std::string& reason) {
  Credit(1);
  const v1::Grant grant = NextGrant();
  std::vector<v1::TileResult> results;
  for (const uint32_t tile : grant.tiles()) {
    v1::TileResult& result = results.emplace_back(Result(grant, tile));
    result.clear_stats();
    result.mutable_failure()->set_code(8);
    result.mutable_failure()->set_message(reason);
  }
  Push(results);
}

v1::ResultAck FakeWorker::Push(const std::vector<v1::TileResult>& results, uint32_t credit) {
  v1::ResultBatch batch;
  batch.set_session_id(welcome_.session_id());
  batch.set_epoch(welcome_.epoch());
  batch.set_batch_id(next_batch_++);
  batch.set_credit(credit);
  for (const v1::TileResult& result : results) *batch.add_tiles() = result;
  v1::ResultAck ack;
  SL_CHECK(results_->Write(batch) && results_->Read(&ack));
  SL_CHECK(ack.batch_id() == batch.batch_id());
  return ack;
}

v1::ResultAck FakeWorker::Render(const v1::Grant& grant, uint32_t credit) {
  std::vector<v1::TileResult> results;
  for (const uint32_t tile : grant.tiles()) results.push_back(Result(grant, tile));
  return Push(results, credit);
}

void FakeWorker::RenderUntilForgotten() {
  Credit(1);
  v1::CoordinatorMessage message;
  while (Next(message) && !message.has_forget_job()) {
    if (!message.has_grant()) continue;
    Render(message.grant());
    Credit(1);
  }
}

}  // namespace shutterline::test
