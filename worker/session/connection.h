#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/container/flat_hash_map.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>
#include <grpcpp/grpcpp.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "shutterline/v1/workers.grpc.pb.h"
#include "worker/loop/lease_board.h"
#include "worker/loop/result_buffer.h"

namespace shutterline::worker {

/// One registration with the coordinator: the two streams and the threads that serve them. Used once:
/// made, Run, gone. Four threads, so that nothing waits for anything else:
///
///   Run's caller  reads Session: jobs, leases, revocations
///   pulse         writes Session: heartbeats, credit, draining
///   sender        writes PushResults
///   receiver      reads PushResults: acknowledgements
class Connection {
 public:
  struct Options {
    int slots = 1;           ///< Threads that render.
    absl::Duration gather;   ///< How long a result waits for company, where the coordinator does not say.
    absl::Duration closing;  ///< How long the coordinator may take to close after we have left.
  };

  Connection(v1::Workers::StubInterface& stub, const v1::Welcome& welcome, const Options& options,
             LeaseBoard& board, ResultBuffer& results, const Clock& clock);

  /// Serves the streams until one of them ends. OK where the coordinator or we closed it in order.
  absl::Status Run();

  // From any thread, at any time:
  void Wake();        ///< Credit may be given, or there may be nothing left to wait for.
  void BeginDrain();  ///< No more leases; leave when all that we hold is acknowledged.
  void Cancel();      ///< Break both streams.
  /// True once BeginDrain has led to an orderly end.
  bool left() const { return left_; }

 private:
  using SessionStream = grpc::ClientReaderWriterInterface<v1::WorkerMessage, v1::CoordinatorMessage>;
  using ResultStream = grpc::ClientReaderWriterInterface<v1::ResultBatch, v1::ResultAck>;

  void Handle(const v1::CoordinatorMessage& message);
  void HandleJob(const v1::JobDetails& details);
  void HandleGrant(const v1::Grant& grant);
  void HandleAdoption(const v1::Grant& grant);

  void Pulse();
  bool WriteDueLocked(absl::Duration& next_beat) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void NoteStarvation() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Writes without the lock. False where the stream is broken.
  bool Write(const v1::WorkerMessage& message) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Leave() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  void SendResults();
  v1::ResultBatch MakeMessage(const ResultBuffer::Batch& batch);
  /// Notes that so many leases are asked for, and returns the number; 0: none are needed.
  /// `along`: with results.
  size_t AskForLeasesLocked(bool along) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ReceiveAcks();
  absl::Status HandleAck(const v1::ResultAck& ack);

  v1::Workers::StubInterface& stub_;
  const v1::Welcome welcome_;
  const Options options_;
  const absl::Duration heartbeat_interval_;
  LeaseBoard& board_;
  ResultBuffer& results_;
  const Clock& clock_;
  const uint64_t board_session_;

  grpc::ClientContext session_context_, results_context_;
  std::unique_ptr<SessionStream> session_;
  std::unique_ptr<ResultStream> push_;
  absl::flat_hash_map<std::string, std::shared_ptr<WorkerJob>> jobs_;  // Used by Run's caller alone.

  absl::Mutex mutex_;
  absl::CondVar changed_;
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  bool heard_ ABSL_GUARDED_BY(mutex_) = false;  // Something has come: the coordinator knows the stream.
  bool said_draining_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  bool receiver_ended_ ABSL_GUARDED_BY(mutex_) = false;
  size_t credit_ ABSL_GUARDED_BY(mutex_) = 0;     // Given and not used by a grant yet.
  size_t extra_ ABSL_GUARDED_BY(mutex_) = 0;      // Leases beyond those that are kept otherwise.
  bool starved_ ABSL_GUARDED_BY(mutex_) = false;  // At the last heartbeat.
  std::vector<uint64_t> to_return_ ABSL_GUARDED_BY(mutex_);
  absl::Status ack_status_ ABSL_GUARDED_BY(mutex_);  // What was wrong with an acknowledgement.
  std::atomic<bool> leaving_ = false, left_ = false;
};

}  // namespace shutterline::worker
