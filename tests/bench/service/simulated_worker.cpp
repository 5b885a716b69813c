#include "tests/bench/service/simulated_worker.h"

#include <absl/time/clock.h>

#include <algorithm>

#include "proto/convert/status.h"
#include "tests/bench/service/service_bench.h"
#include "worker/loop/credit.h"

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
  v1::ResultBatch introduction;
  introduction.set_session_id(welcome_.session_id());
  introduction.set_epoch(welcome_.epoch());
  results_->Send(std::move(introduction));
  {
    absl::MutexLock lock(&mutex_);
    gather_.SetPace(welcome_.has_gather() ? convert::FromProto(welcome_.gather()) : absl::Milliseconds(5));
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

uint32_t SimulatedWorker::LeasesToAsk(bool along) {
  const auto leases = uint32_t(worker::LeasesToAskFor(leases_.size() + credit_, 1, 0, along));
  credit_ += leases;
  return leases;
}

void SimulatedWorker::AskForMore() {
  const size_t held = leases_.size() + credit_;
  if (worker::LeasesToAskFor(held, 1, 0, false) == 0) return;
  if (welcome_.credit_with_results() && heard_ && !finished_.empty() && worker::MayGoWithResults(held, 1)) {
    gather_.Hurry();
    return SendDue();
  }
  const uint32_t leases = LeasesToAsk(false);
  ++count_.credits;
  v1::WorkerMessage message;
  message.mutable_credit()->set_leases(leases);
  session_->Send(std::move(message));
}

void SimulatedWorker::OnMessage(const v1::CoordinatorMessage& message) {
  absl::MutexLock lock(&mutex_);
  heard_ = true;
  if (message.has_revoke()) {
    gather_.Hurry();
    return SendDue();
  }
  if (!message.has_grant()) return;
  ++count_.grants;
  leases_.push_back(message.grant());
  live_[message.grant().lease_id()] = message.grant().tiles_size();
  if (credit_ > 0) --credit_;
  if (busy_ || stopping_) return;
  const absl::Time now = absl::Now();
  count_.idle += now - idle_since_;
  BeginTile(now);
}

void SimulatedWorker::BeginTile(absl::Time start) {
  busy_ = true;
  if (leases_.front().send_at_once()) {
    gather_.Hurry();
    SendDue();
  }
  const absl::Time end = start + tile_time_;
  later_(end, [this, end] { Finished(end); });
}

bool SimulatedWorker::Holds(const std::string& job, int frame) const {
  return std::any_of(leases_.begin(), leases_.end(),
                     [&](const v1::Grant& lease) { return lease.frame() == frame && lease.job_id() == job; });
}

void SimulatedWorker::Finished(absl::Time end) {
  absl::MutexLock lock(&mutex_);
  if (stopping_) return;
  v1::Grant& lease = leases_.front();
  const Result result{lease.job_id(), lease.frame(), lease.tiles(0), lease.lease_id()};
  const bool at_once = lease.send_at_once();
  finished_.push_back(result);
  gather_.Add(pixels_->size(), clock_.Monotonic());
  lease.mutable_tiles()->erase(lease.tiles().begin());
  if (lease.tiles().empty()) leases_.pop_front();
  if (at_once || !Holds(result.job, result.frame)) gather_.Hurry();
  if (leases_.empty()) {
    busy_ = false;
    idle_since_ = absl::Now();
  } else {
    BeginTile(end);
  }
  SendDue();
  AskForMore();
}

void SimulatedWorker::SendDue() {
  const absl::Duration now = clock_.Monotonic();
  const absl::Duration due = gather_.Due(size_t(welcome_.max_batch_bytes()) / 2);
  if (due <= now) return SendBatch();
  if (will_look_ || finished_.empty()) return;
  will_look_ = true;
  later_(absl::Now() + (due - now), [this] {
    absl::MutexLock lock(&mutex_);
    will_look_ = false;
    if (!stopping_) SendDue();
  });
}

void SimulatedWorker::SendBatch() {
  v1::ResultBatch batch;
  std::vector<uint64_t>& leases = under_way_.emplace_back();
  const int64_t nanoseconds = absl::ToInt64Nanoseconds(tile_time_);
  while (!finished_.empty()) {
    Result& done = finished_.front();
    v1::TileResult& result = *batch.add_tiles();
    result.set_job_id(std::move(done.job));
    result.set_frame(done.frame);
    result.set_tile(done.tile);
    result.set_lease_id(done.lease);
    result.set_pixels(*pixels_);
    result.mutable_render_time()->set_seconds(nanoseconds / 1'000'000'000);
    result.mutable_render_time()->set_nanos(int32_t(nanoseconds % 1'000'000'000));
    leases.push_back(done.lease);
    gather_.Remove(pixels_->size());
    finished_.pop_front();
  }
  batch.set_session_id(welcome_.session_id());
  batch.set_epoch(welcome_.epoch());
  batch.set_batch_id(++batches_);
  if (welcome_.credit_with_results() && heard_) batch.set_credit(LeasesToAsk(true));
  results_->Send(std::move(batch));
}

void SimulatedWorker::OnAck(const v1::ResultAck& ack) {
  absl::MutexLock lock(&mutex_);
  ++count_.batches;
  count_.tiles += std::count(ack.outcomes().begin(), ack.outcomes().end(), v1::ResultAck::OUTCOME_STORED);
  if (ack.has_gather()) gather_.SetPace(convert::FromProto(ack.gather()));
  if (under_way_.empty()) return;
  for (const uint64_t lease : under_way_.front()) {
    const auto live = live_.find(lease);
    if (live != live_.end() && --live->second == 0) live_.erase(live);
  }
  under_way_.pop_front();
}

void SimulatedWorker::Heartbeat() {
  v1::WorkerMessage message;
  message.mutable_heartbeat();
  absl::MutexLock lock(&mutex_);
  if (stopping_) return;
  for (const auto& [lease, tiles] : live_) message.mutable_heartbeat()->add_lease_ids(lease);
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
