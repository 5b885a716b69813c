#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/server_context.h>

#include <deque>
#include <optional>

#include "server/api/stream_limits.h"
#include "server/control/farm.h"
#include "shutterline/v1/workers.pb.h"

namespace shutterline::server {

/// One Session stream: tells the farm what the worker says, as it comes, and writes what the farm sends, one
/// message at a time. The farm's mutex may be held when Send and Close are called, ours never when we call
/// the farm. A stream whose Open does not come in time ends with DEADLINE_EXCEEDED.
class SessionReactor final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                             private WorkerSink {
 public:
  SessionReactor(Farm& farm, grpc::CallbackServerContext* context, StreamLimits& limits);

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
  StreamLimits& limits_;
  StreamBudget::Slot slot_;
  StreamDeadlines::Id open_deadline_ = 0;
  grpc::ByteBuffer incoming_;
  std::optional<WorkerId> worker_;  ///< After Open. Of the reading side alone.

  absl::Mutex mutex_;
  std::deque<grpc::ByteBuffer> outgoing_ ABSL_GUARDED_BY(mutex_);  ///< The first is being written.
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> closing_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace shutterline::server
