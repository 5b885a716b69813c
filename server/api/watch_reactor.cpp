#include "server/api/watch_reactor.h"

#include "proto/convert/status.h"
#include "server/api/messages.h"

namespace shutterline::server {

WatchReactor::WatchReactor(Farm& farm, WorkPool& pool, const v1::WatchRequest& request)
    : farm_(farm), pool_(pool), job_id_(request.job_id()), seq_(request.after_seq()) {
  if (!pool_.Run([this] { Begin(); })) End(absl::UnavailableError("the coordinator is stopping"));
}

void WatchReactor::Begin() {
  const absl::Status status = farm_.AddWatcher(job_id_, this);
  if (!status.ok()) return End(status);
  watching_ = true;
  Look();
}

void WatchReactor::OnChange() {
  {
    absl::MutexLock lock(&mutex_);
    changed_ = true;
    if (state_ != State::kResting) return;
    state_ = State::kBusy;
  }
  LookSoon();
}

void WatchReactor::OnCancel() {
  {
    absl::MutexLock lock(&mutex_);
    cancelled_ = true;
    if (state_ != State::kResting) return;
    state_ = State::kBusy;
  }
  LookSoon();
}

void WatchReactor::LookSoon() {
  if (!pool_.Run([this] { Look(); })) End(absl::UnavailableError("the coordinator is stopping"));
}

void WatchReactor::Look() {
  while (true) {
    {
      absl::MutexLock lock(&mutex_);
      changed_ = false;
    }
    bool ended = false;
    const std::optional<JobChange> change = farm_.NextChange(job_id_, seq_, ended);
    bool cancelled = false;
    {
      absl::MutexLock lock(&mutex_);
      cancelled = cancelled_;
      if (!change && !ended && !cancelled) {
        if (changed_) continue;  // Between our look and now.
        state_ = State::kResting;
        return;
      }
    }
    if (cancelled) return End(absl::CancelledError("the watcher went away"));
    if (!change) return End(absl::OkStatus());
    seq_ = change->seq;
    event_ = ToMessage(*change);
    StartWrite(&event_);
    return;
  }
}

void WatchReactor::OnWriteDone(bool ok) {
  if (!ok) return End(absl::CancelledError("the watcher went away"));
  LookSoon();
}

void WatchReactor::End(const absl::Status& status) {
  {
    absl::MutexLock lock(&mutex_);
    state_ = State::kFinished;
  }
  Finish(convert::ToGrpc(status));  // Last: OnDone may free this object at once.
}

void WatchReactor::OnDone() {
  if (watching_) farm_.RemoveWatcher(job_id_, this);
  delete this;
}

}  // namespace shutterline::server
