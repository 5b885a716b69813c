#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/server_context.h>

#include <deque>
#include <optional>

#include "server/control/farm.h"
#include "shutterline/v1/workers.pb.h"

namespace shutterline::server {

/// One Session stream: tells the farm what the worker says, as it comes, and writes what the farm sends, one
/// message at a time. The farm's mutex may be held when Send and Close are called, ours never when we call
/// the farm.
class SessionReactor final : public grpc::ServerBidiReactor<v1::WorkerMessage, v1::CoordinatorMessage>,
                             private WorkerSink {
 public:
  SessionReactor(Farm& farm, grpc::CallbackServerContext* context);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone() override;

 private:
  void Send(WorkerEvent event) override;
  void Close(const absl::Status& status) override;

  absl::Status Handle(const v1::WorkerMessage& message);
  /// Finishes the call if it is to be closed and nothing is left to write; may free this object.
  void FinishIfDone();

  Farm& farm_;
  grpc::CallbackServerContext* const context_;
  v1::WorkerMessage incoming_;
  std::optional<WorkerId> worker_;  ///< After Open. Of the reading side alone.

  absl::Mutex mutex_;
  std::deque<v1::CoordinatorMessage> outgoing_ ABSL_GUARDED_BY(mutex_);  ///< The first is being written.
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> closing_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace shutterline::server
