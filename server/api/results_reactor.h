#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/server_context.h>

#include <deque>
#include <optional>
#include <vector>

#include "server/api/stream_limits.h"
#include "server/control/farm.h"
#include "server/control/result_committer.h"
#include "shutterline/v1/workers.pb.h"

namespace shutterline::server {

/// One PushResults stream: batches go to the committer as they come, several at a time, so that they share
/// its flushes; acknowledgements go back in their order. Reading pauses while too many bytes wait. A stream
/// whose first batch does not come in time ends with DEADLINE_EXCEEDED.
class ResultsReactor final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  ResultsReactor(Farm& farm, ResultCommitter& committer, StreamLimits& limits);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone() override;

 private:
  absl::Status Handle(v1::ResultBatch& batch);
  void Committed(uint64_t batch_id, size_t bytes, const absl::Status& status,
                 const std::vector<ReportOutcome>& outcomes);
  void Close(const absl::Status& status);
  /// Whether the call is to be closed and nothing is under way. Says so once: then the caller, and only it,
  /// calls Finish, with the mutex released, and touches this object no more.
  bool TakeFinish(grpc::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Farm& farm_;
  ResultCommitter& committer_;
  StreamLimits& limits_;
  StreamBudget::Slot slot_;
  StreamDeadlines::Id first_deadline_ = 0;
  grpc::ByteBuffer incoming_;
  std::optional<WorkerId> worker_;  ///< After the first batch. Of the reading side alone.

  absl::Mutex mutex_;
  std::deque<grpc::ByteBuffer> outgoing_ ABSL_GUARDED_BY(mutex_);  ///< The first is being written.
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  int pending_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Batches at the committer.
  size_t pending_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool read_paused_ ABSL_GUARDED_BY(mutex_) = false;
  bool handling_ ABSL_GUARDED_BY(mutex_) = false;  ///< OnReadDone is at work: the object must live.
  std::optional<absl::Status> closing_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace shutterline::server
