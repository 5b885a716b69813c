#include "server/api/session_reactor.h"

#include <absl/strings/str_cat.h>

#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "proto/convert/status.h"
#include "server/api/limits.h"
#include "server/api/messages.h"
#include "server/api/wire.h"

namespace shutterline::server {

SessionReactor::SessionReactor(Farm& farm, grpc::CallbackServerContext* context, StreamLimits& limits)
    : farm_(farm), context_(context), limits_(limits) {
  if (const absl::Status taken = slot_.Take(limits_.sessions); !taken.ok()) {
    Close(taken);
    return;
  }
  open_deadline_ = limits_.deadlines.Add(limits_.config.first_message, [this] {
    Close(absl::DeadlineExceededError("open: did not come in time"));
  });
  absl::MutexLock lock(&mutex_);
  if (!finished_) StartRead(&incoming_);
}

absl::Status SessionReactor::Handle(const v1::WorkerMessage& message) {
  if (message.has_open() != !worker_.has_value()) {
    return absl::InvalidArgumentError("open: must come first, and once");
  }
  switch (message.what_case()) {
    case v1::WorkerMessage::kOpen: {
      SL_ASSIGN_OR_RETURN(const std::vector<HeldLease> held, HeldOf(message.open()));
      SL_ASSIGN_OR_RETURN(worker_,
                          farm_.Attach(message.open().session_id(), message.open().epoch(), held, this));
      return absl::OkStatus();
    }
    case v1::WorkerMessage::kCredit:
      farm_.AddCredit(*worker_, message.credit().leases());
      return absl::OkStatus();
    case v1::WorkerMessage::kHeartbeat: {
      const auto& leases = message.heartbeat().lease_ids();
      if (leases.size() > kMaxHeartbeatLeases) {
        return absl::InvalidArgumentError(
            absl::StrCat("heartbeat.lease_ids: has ", leases.size(), " entries"));
      }
      farm_.Heartbeat(*worker_, std::vector<LeaseId>(leases.begin(), leases.end()));
      return absl::OkStatus();
    }
    case v1::WorkerMessage::kReturnLeases: {
      const auto& leases = message.return_leases().lease_ids();
      farm_.ReturnLeases(*worker_, std::vector<LeaseId>(leases.begin(), leases.end()));
      return absl::OkStatus();
    }
    case v1::WorkerMessage::kDraining:
      farm_.WorkerDrains(*worker_);
      return absl::OkStatus();
    case v1::WorkerMessage::WHAT_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError("a message of a kind that is not known");
}

void SessionReactor::OnReadDone(bool ok) {
  if (!ok) {
    // Both ends of a stream look like this: the worker has closed it, or it is gone.
    if (worker_) farm_.Detach(*worker_, this, !context_->IsCancelled());
    return Close(absl::OkStatus());
  }
  absl::Status status;
  {
    v1::WorkerMessage message;  // Not kept: it may have been large.
    status = Decode(incoming_, message);
    incoming_.Clear();
    if (status.ok()) status = Handle(message);
  }
  if (!status.ok()) return Close(status);
  limits_.deadlines.Cancel(open_deadline_);
  absl::MutexLock lock(&mutex_);
  if (!finished_) StartRead(&incoming_);
}

void SessionReactor::Send(WorkerEvent event) {
  grpc::ByteBuffer message = Encode(ToMessage(event));
  absl::MutexLock lock(&mutex_);
  if (closing_) return;
  outgoing_.push_back(std::move(message));
  if (writing_) return;
  writing_ = true;
  StartWrite(&outgoing_.front());
}

void SessionReactor::OnWriteDone(bool ok) {
  {
    absl::MutexLock lock(&mutex_);
    writing_ = false;
    outgoing_.pop_front();
    if (!ok) {
      outgoing_.clear();
      if (!closing_) closing_ = absl::CancelledError("the worker went away");
    }
    if (!outgoing_.empty()) {
      writing_ = true;
      StartWrite(&outgoing_.front());
      return;
    }
  }
  FinishIfDone();
}

void SessionReactor::Close(const absl::Status& status) {
  {
    absl::MutexLock lock(&mutex_);
    if (!closing_) closing_ = status;
  }
  FinishIfDone();
}

void SessionReactor::FinishIfDone() {
  grpc::Status status;
  {
    absl::MutexLock lock(&mutex_);
    if (finished_ || writing_ || !closing_) return;
    finished_ = true;
    status = convert::ToGrpc(*closing_);
  }
  slot_.Release();
  Finish(status);  // Last: OnDone may free this object at once.
}

void SessionReactor::OnDone() {
  limits_.deadlines.Cancel(open_deadline_);
  // Ours no longer: the farm must not send to a freed object. An orderly end has been told before.
  if (worker_) farm_.Detach(*worker_, this, false);
  delete this;
}

}  // namespace shutterline::server
