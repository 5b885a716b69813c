#include "worker/session/coordinator_session.h"

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "proto/convert/status.h"

namespace shutterline::worker {
namespace {

/// Versions of the protocol that this worker speaks.
constexpr uint32_t kProtocolLow = 1, kProtocolHigh = 1;

/// Errors of registration that the next attempt would meet again.
bool IsHopeless(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kUnimplemented:
      return true;
    default:
      return false;
  }
}

}  // namespace

CoordinatorSession::CoordinatorSession(std::shared_ptr<grpc::Channel> channel, SessionOptions options,
                                       LeaseBoard& board, ResultBuffer& results, const Clock& clock)
    : stub_(v1::Workers::NewStub(channel)),
      options_(std::move(options)),
      board_(board),
      results_(results),
      clock_(clock),
      backoff_(clock, options_.backoff, options_.seed) {
  board_.OnProgress([this] {
    absl::MutexLock lock(&mutex_);
    if (connection_ != nullptr) connection_->Wake();
  });
}

CoordinatorSession::~CoordinatorSession() {
  Stop();
}

void CoordinatorSession::Start() {
  SL_CHECK(!thread_.joinable());
  thread_ = std::thread([this] { Run(); });
}

void CoordinatorSession::Drain() {
  absl::MutexLock lock(&mutex_);
  if (draining_) return;
  draining_ = true;
  drain_deadline_ = clock_.Monotonic() + options_.drain_patience;
  if (connection_ != nullptr) connection_->BeginDrain();
  changed_.SignalAll();
}

void CoordinatorSession::Stop() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
    if (register_context_ != nullptr) register_context_->TryCancel();
    if (connection_ != nullptr) connection_->Cancel();
    changed_.SignalAll();
  }
  if (thread_.joinable()) thread_.join();
}

absl::Status CoordinatorSession::Wait() {
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(&ended_));
  return result_;
}

int CoordinatorSession::registrations() const {
  absl::MutexLock lock(&mutex_);
  return registrations_;
}

void CoordinatorSession::Run() {
  while (true) {
    const absl::Status status = RegisterAndServe();
    if (!ShouldRetry(status)) break;
    const absl::Duration delay = backoff_.NextDelay();
    spdlog::warn("no coordinator, trying again delay_ms={:.0f} reason={}", absl::ToDoubleMilliseconds(delay),
                 LogValue(status.ok() ? "the stream was closed" : status.ToString()));
    Pause(delay);
  }
  absl::MutexLock lock(&mutex_);
  ended_ = true;
}

bool CoordinatorSession::ShouldRetry(const absl::Status& status) {
  const size_t undelivered = results_.size();
  const bool idle = board_.Idle();
  absl::MutexLock lock(&mutex_);
  if (stopping_) {
    result_ = absl::CancelledError("the worker was stopped");
  } else if (draining_ && idle && undelivered == 0) {
    result_ = absl::OkStatus();
  } else if (IsHopeless(status)) {
    result_ = Annotate(status, "register with the coordinator");
  } else if (clock_.Monotonic() >= drain_deadline_) {
    result_ = absl::UnavailableError(
        absl::StrCat("left with ", undelivered, " tiles undelivered: ", status.message()));
  } else {
    return true;
  }
  return false;
}

void CoordinatorSession::Pause(absl::Duration delay) {
  absl::MutexLock lock(&mutex_);
  const absl::Duration until = clock_.Monotonic() + delay;
  const bool was_draining = draining_;
  while (!stopping_ && draining_ == was_draining && clock_.Monotonic() < until) {
    changed_.WaitWithTimeout(&mutex_, until - clock_.Monotonic());
  }
}

absl::Status CoordinatorSession::RegisterAndServe() {
  SL_ASSIGN_OR_RETURN(const v1::Welcome welcome, Register());
  Connection connection(*stub_, welcome,
                        {.slots = options_.slots, .gather = options_.gather, .closing = options_.closing},
                        board_, results_, clock_);
  bool draining = false;
  {
    absl::MutexLock lock(&mutex_);
    if (stopping_) return absl::CancelledError("the worker was stopped");
    ++registrations_;
    connection_ = &connection;
    draining = draining_;
  }
  if (draining) connection.BeginDrain();
  backoff_.Connected();
  spdlog::info("registered epoch={} session={}", welcome.epoch(), LogValue(welcome.session_id()));
  absl::Status status = connection.Run();
  {
    absl::MutexLock lock(&mutex_);
    connection_ = nullptr;
  }
  // The session's leases are over, but threads go on: the next session is asked to adopt what they are at.
  board_.Suspend();
  return status;
}

absl::StatusOr<v1::Welcome> CoordinatorSession::Register() {
  v1::Hello hello;
  hello.set_worker_uuid(options_.identity.uuid);
  hello.set_boot_id(options_.identity.boot_id);
  hello.mutable_protocol()->set_low(kProtocolLow);
  hello.mutable_protocol()->set_high(kProtocolHigh);
  hello.set_build_id(options_.identity.build_id);
  hello.set_isa(options_.identity.isa);
  hello.set_slots(uint32_t(options_.slots));
  hello.set_name(options_.identity.name);
  for (const WorkerExit& exit : options_.identity.exits) {
    v1::WorkerExit& said = *hello.add_exits();
    said.set_boot_id(exit.boot_id);
    said.set_signal(exit.signal);
    said.set_log_tail(exit.log_tail);
    for (const TileAtHand& tile : exit.tiles) {
      v1::TileName& name = *said.add_tiles();
      name.set_job_id(tile.job_id);
      name.set_frame(tile.frame);
      name.set_tile(tile.tile);
    }
  }

  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() +
                       absl::ToChronoMilliseconds(options_.register_deadline));
  {
    absl::MutexLock lock(&mutex_);
    if (stopping_) return absl::CancelledError("the worker was stopped");
    register_context_ = &context;
  }
  v1::Welcome welcome;
  const absl::Status status = convert::FromGrpc(stub_->Register(&context, hello, &welcome));
  {
    absl::MutexLock lock(&mutex_);
    register_context_ = nullptr;
  }
  SL_RETURN_IF_ERROR(status);
  if (welcome.protocol() < kProtocolLow || welcome.protocol() > kProtocolHigh) {
    return absl::FailedPreconditionError(absl::StrCat("the coordinator wants protocol ", welcome.protocol(),
                                                      ", this worker speaks ", kProtocolLow, " to ",
                                                      kProtocolHigh));
  }
  return welcome;
}

}  // namespace shutterline::worker
