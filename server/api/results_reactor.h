#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/server_context.h>

#include <deque>
#include <optional>
#include <vector>

#include "server/control/farm.h"
#include "server/control/result_committer.h"
#include "shutterline/v1/workers.pb.h"

namespace shutterline::server {

/// One PushResults stream: batches go to the committer as they come, several at a time, so that they share
/// its flushes; acknowledgements go back in their order. Reading pauses while too many bytes wait.
class ResultsReactor final : public grpc::ServerBidiReactor<v1::ResultBatch, v1::ResultAck> {
 public:
  ResultsReactor(Farm& farm, ResultCommitter& committer);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  absl::Status Handle();
  void Committed(uint64_t batch_id, size_t bytes, const absl::Status& status,
                 const std::vector<ReportOutcome>& outcomes);
  void Close(const absl::Status& status);
  /// Whether the call is to be closed and nothing is under way. Says so once: then the caller, and only it,
  /// calls Finish, with the mutex released, and touches this object no more.
  bool TakeFinish(grpc::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Farm& farm_;
  ResultCommitter& committer_;
  v1::ResultBatch incoming_;
  std::optional<WorkerId> worker_;  ///< After the first batch. Of the reading side alone.

  absl::Mutex mutex_;
  std::deque<v1::ResultAck> outgoing_ ABSL_GUARDED_BY(mutex_);  ///< The first is being written.
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  int pending_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Batches at the committer.
  size_t pending_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool read_paused_ ABSL_GUARDED_BY(mutex_) = false;
  bool handling_ ABSL_GUARDED_BY(mutex_) = false;  ///< OnReadDone is at work: the object must live.
  std::optional<absl::Status> closing_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace shutterline::server
