#include "tests/bench/service/simulated_worker.h"

#include <absl/time/clock.h>

#include <algorithm>

#include "tests/bench/service/service_bench.h"

namespace shutterline::bench {

/// One bidirectional call: messages to send queue up, messages that come go to `received`.
template <typename Request, typename Response>
class SimulatedWorker::Stream final : public grpc::ClientBidiReactor<Request, Response> {
 public:
  explicit Stream(std::function<void(const Response&)> received) : received_(std::move(received)) {}

  grpc::ClientContext context;

  void Begin() {
    this->AddHold();  // Writes come from other threads.
    this->StartRead(&incoming_);
    this->StartCall();
  }
  void Send(Request message) {
    absl::MutexLock lock(&mutex_);
    if (over_) return;
    outgoing_.push_back(std::move(message));
    if (outgoing_.size() == 1) this->StartWrite(&outgoing_.front());
  }
  void Break() {
    {
      absl::MutexLock lock(&mutex_);
      over_ = true;
    }
    context.TryCancel();
    this->RemoveHold();
    absl::MutexLock lock(&mutex_, absl::Condition(&done_));
  }

  void OnReadDone(bool ok) override {
    if (!ok) {
      absl::MutexLock lock(&mutex_);
      broken_ = broken_ || !over_;
      return;
    }
    received_(incoming_);
    this->StartRead(&incoming_);
  }
  void OnWriteDone(bool ok) override {
    absl::MutexLock lock(&mutex_);
    outgoing_.pop_front();
    if (ok && !over_ && !outgoing_.empty()) this->StartWrite(&outgoing_.front());
  }
  void OnDone(const grpc::Status&) override {
    absl::MutexLock lock(&mutex_);
    done_ = true;
  }
  bool broken() const {
    absl::MutexLock lock(&mutex_);
    return broken_;
  }

 private:
  const std::function<void(const Response&)> received_;
  Response incoming_;
  mutable absl::Mutex mutex_;
  std::deque<Request> outgoing_ ABSL_GUARDED_BY(mutex_);  ///< The first is being written.
  bool over_ ABSL_GUARDED_BY(mutex_) = false;
  bool broken_ ABSL_GUARDED_BY(mutex_) = false;
  bool done_ ABSL_GUARDED_BY(mutex_) = false;
};

SimulatedWorker::SimulatedWorker(const std::string& address, const std::string& uuid,
                                 const std::string* pixels, absl::Duration tile_time, Later later)
    : pixels_(pixels), tile_time_(tile_time), later_(std::move(later)) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  stub_ =
      v1::Workers::NewStub(grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
  welcome_ = RegisterWorker(*stub_, uuid);
}

SimulatedWorker::~SimulatedWorker() = default;

void SimulatedWorker::Start() {
  session_ = std::make_unique<Session>([this](const v1::CoordinatorMessage& message) { OnMessage(message); });
  results_ = std::make_unique<Results>([this](const v1::ResultAck& ack) { OnAck(ack); });
  stub_->async()->Session(&session_->context, session_.get());
  stub_->async()->PushResults(&results_->context, results_.get());
  session_->Begin();
  results_->Begin();
  v1::WorkerMessage open;
  open.mutable_open()->set_session_id(welcome_.session_id());
  open.mutable_open()->set_epoch(welcome_.epoch());
  session_->Send(std::move(open));
  {
    absl::MutexLock lock(&mutex_);
    idle_since_ = absl::Now();
    AskForMore();
  }
  later_(absl::Now() + absl::Seconds(5), [this] { Heartbeat(); });
}

void SimulatedWorker::Stop() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  session_->Break();
  results_->Break();
}

void SimulatedWorker::AskForMore() {
  const auto held = uint32_t(leases_.size()) + credit_;
  if (held >= 2) return;
  credit_ += 3 - held;
  v1::WorkerMessage message;
  message.mutable_credit()->set_leases(3 - held);
  session_->Send(std::move(message));
}

void SimulatedWorker::OnMessage(const v1::CoordinatorMessage& message) {
  if (!message.has_grant()) return;
  absl::MutexLock lock(&mutex_);
  leases_.push_back(message.grant());
  if (credit_ > 0) --credit_;
  if (busy_ || stopping_) return;
  const absl::Time now = absl::Now();
  count_.idle += now - idle_since_;
  BeginTile(now);
}

void SimulatedWorker::BeginTile(absl::Time now) {
  busy_ = true;
  v1::Grant& lease = leases_.front();
  v1::Grant tile;
  tile.set_lease_id(lease.lease_id());
  tile.set_job_id(lease.job_id());
  tile.set_frame(lease.frame());
  tile.add_tiles(lease.tiles(0));
  later_(now + tile_time_, [this, tile] { Finished(tile); });
  lease.mutable_tiles()->erase(lease.tiles().begin());
  if (lease.tiles().empty()) leases_.pop_front();
}

void SimulatedWorker::Finished(const v1::Grant& tile) {
  v1::ResultBatch batch;
  v1::TileResult& result = *batch.add_tiles();
  result.set_job_id(tile.job_id());
  result.set_frame(tile.frame());
  result.set_tile(tile.tiles(0));
  result.set_lease_id(tile.lease_id());
  result.set_pixels(*pixels_);
  const int64_t nanoseconds = absl::ToInt64Nanoseconds(tile_time_);
  result.mutable_render_time()->set_seconds(nanoseconds / 1'000'000'000);
  result.mutable_render_time()->set_nanos(int32_t(nanoseconds % 1'000'000'000));
  absl::MutexLock lock(&mutex_);
  if (stopping_) return;
  const absl::Time now = absl::Now();
  if (leases_.empty()) {
    busy_ = false;
    idle_since_ = now;
  } else {
    BeginTile(now);
  }
  batch.set_session_id(welcome_.session_id());
  batch.set_epoch(welcome_.epoch());
  batch.set_batch_id(++batches_);
  results_->Send(std::move(batch));
  AskForMore();
}

void SimulatedWorker::OnAck(const v1::ResultAck& ack) {
  absl::MutexLock lock(&mutex_);
  count_.tiles += std::count(ack.outcomes().begin(), ack.outcomes().end(), v1::ResultAck::OUTCOME_STORED);
}

void SimulatedWorker::Heartbeat() {
  v1::WorkerMessage message;
  message.mutable_heartbeat();
  absl::MutexLock lock(&mutex_);
  if (stopping_) return;
  for (const v1::Grant& lease : leases_) message.mutable_heartbeat()->add_lease_ids(lease.lease_id());
  session_->Send(std::move(message));
  later_(absl::Now() + absl::Seconds(5), [this] { Heartbeat(); });
}

void SimulatedWorker::BeginCount() {
  absl::MutexLock lock(&mutex_);
  count_ = {};
  if (!busy_) idle_since_ = absl::Now();
}

SimulatedWorker::Count SimulatedWorker::EndCount() {
  absl::MutexLock lock(&mutex_);
  Count count = count_;
  if (!busy_) count.idle += absl::Now() - idle_since_;
  count.broken = session_->broken() || results_->broken();
  return count;
}

}  // namespace shutterline::bench
