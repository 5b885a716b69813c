#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/server_context.h>

#include <optional>
#include <string>
#include <utility>

#include "proto/convert/status.h"
#include "server/api/stream_budget.h"
#include "server/control/farm.h"
#include "server/control/work_pool.h"

namespace shutterline::server {

/// One call that follows a job, message by message. At any time it is resting (until the job changes or the
/// caller goes away), looking for the next message on the pool, or writing one; the step that finds that
/// there will be nothing more finishes the call. Frees itself.
template <typename Message>
class FollowingReactor : public grpc::ServerWriteReactor<Message>, private JobWatcher {
 public:
  void OnWriteDone(bool ok) final {
    if (!ok) return End(absl::CancelledError("the watcher went away"));
    LookSoon();
  }

  void OnCancel() final {
    {
      absl::MutexLock lock(&mutex_);
      cancelled_ = true;
      if (state_ != State::kResting) return;
      state_ = State::kBusy;
    }
    LookSoon();
  }

  void OnDone() final {
    if (watching_) farm_.RemoveWatcher(job_id_, this);
    delete this;
  }

 protected:
  FollowingReactor(Farm& farm, WorkPool& pool, std::string job_id)
      : farm_(farm), pool_(pool), job_id_(std::move(job_id)) {}

  /// Last in the constructor of the class that is derived: from then on Next may be called. The call ends at
  /// once where `budget` is spent.
  void Start(StreamBudget& budget) {
    if (const absl::Status taken = slot_.Take(budget); !taken.ok()) return End(taken);
    if (!pool_.Run([this] { Begin(); })) End(absl::UnavailableError("the coordinator is stopping"));
  }

  /// What there is to say now; none: nothing yet or, with `ended`, never again. An error ends the call.
  /// Called on the pool, by one thread at a time.
  virtual absl::StatusOr<std::optional<Message>> Next(bool& ended) = 0;

  Farm& farm() { return farm_; }
  const std::string& job_id() const { return job_id_; }

 private:
  enum class State { kResting, kBusy, kFinished };

  void OnChange() final {
    {
      absl::MutexLock lock(&mutex_);
      changed_ = true;
      if (state_ != State::kResting) return;
      state_ = State::kBusy;
    }
    LookSoon();
  }

  void LookSoon() {
    if (!pool_.Run([this] { Look(); })) End(absl::UnavailableError("the coordinator is stopping"));
  }

  void Begin() {
    const absl::Status status = farm_.AddWatcher(job_id_, this);
    if (!status.ok()) return End(status);
    watching_ = true;
    Look();
  }

  void Look() {
    while (true) {
      {
        absl::MutexLock lock(&mutex_);
        changed_ = false;
      }
      bool ended = false;
      absl::StatusOr<std::optional<Message>> next = Next(ended);
      if (!next.ok()) return End(next.status());
      bool cancelled = false;
      {
        absl::MutexLock lock(&mutex_);
        cancelled = cancelled_;
        if (!*next && !ended && !cancelled) {
          if (changed_) continue;  // Between our look and now.
          state_ = State::kResting;
          return;
        }
      }
      if (cancelled) return End(absl::CancelledError("the watcher went away"));
      if (!*next) return End(absl::OkStatus());
      message_ = **std::move(next);
      this->StartWrite(&message_);
      return;
    }
  }

  void End(const absl::Status& status) {
    {
      absl::MutexLock lock(&mutex_);
      state_ = State::kFinished;
    }
    slot_.Release();
    this->Finish(convert::ToGrpc(status));  // Last: OnDone may free this object at once.
  }

  Farm& farm_;
  WorkPool& pool_;
  StreamBudget::Slot slot_;
  const std::string job_id_;
  bool watching_ = false;
  Message message_;

  absl::Mutex mutex_;
  State state_ ABSL_GUARDED_BY(mutex_) = State::kBusy;
  bool changed_ ABSL_GUARDED_BY(mutex_) = false;  ///< While busy.
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace shutterline::server
