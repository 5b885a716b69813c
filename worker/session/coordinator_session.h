#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>
#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/base/clock.h"
#include "shutterline/v1/workers.grpc.pb.h"
#include "worker/loop/lease_board.h"
#include "worker/loop/result_buffer.h"
#include "worker/session/backoff.h"
#include "worker/session/connection.h"
#include "worker/supervise/worker_exit.h"

namespace shutterline::worker {

/// Who a worker is, as it says at registration.
struct WorkerIdentity {
  std::string uuid;      ///< Whom failures are counted for.
  std::string boot_id;   ///< New with every start of the process.
  std::string build_id;  ///< kBuildId.
  std::string isa;
  std::string name;               ///< For people.
  std::vector<WorkerExit> exits;  ///< How earlier processes of this worker ended: at most 4.
};

struct SessionOptions {
  WorkerIdentity identity;
  int slots = 1;  ///< Threads that render.
  BackoffOptions backoff;
  uint64_t seed = 0;  ///< Of the backoff's jitter.
  absl::Duration register_deadline = absl::Seconds(10);
  /// How long a result waits for company, where the coordinator does not say.
  absl::Duration gather = absl::Milliseconds(5);
  absl::Duration closing = absl::Seconds(5);  ///< How long a last farewell may take.
  /// How long a draining worker goes on trying to deliver its results to a coordinator that is away.
  absl::Duration drain_patience = absl::Seconds(30);
};

/// Keeps a worker registered with its coordinator: registers, serves the two streams, and begins anew
/// after every loss, with backoff, sending again what was not acknowledged. Grants go to the board,
/// results come from the buffer. Has a thread of its own, from Start to the end.
///
///     Start Drain? (Wait | Stop)
///
/// It ends after Drain, after Stop, or where trying again cannot help: another protocol or build
/// (FAILED_PRECONDITION), no permission. Thread-safe.
class CoordinatorSession {
 public:
  CoordinatorSession(std::shared_ptr<grpc::Channel> channel, SessionOptions options, LeaseBoard& board,
                     ResultBuffer& results, const Clock& clock);
  ~CoordinatorSession();  ///< Stop.

  void Start();
  /// Finish what is leased, deliver it, leave. Returns at once.
  void Drain();
  /// Leave now; what was not delivered is lost to us (others will render it). Returns when left.
  void Stop();
  /// Blocks until the session has ended, and says why: OK after Drain, CANCELLED after Stop,
  /// UNAVAILABLE where results could not be delivered before `drain_patience` ran out.
  absl::Status Wait();

  /// Registrations that succeeded so far.
  int registrations() const;

 private:
  void Run();
  absl::Status RegisterAndServe();
  absl::StatusOr<v1::Welcome> Register();
  /// Whether to go on after a connection ended with `status`; if not, sets the session's result.
  bool ShouldRetry(const absl::Status& status);
  void Pause(absl::Duration delay);

  const std::unique_ptr<v1::Workers::StubInterface> stub_;
  const SessionOptions options_;
  LeaseBoard& board_;
  ResultBuffer& results_;
  const Clock& clock_;
  Backoff backoff_;  // Used by the thread alone.

  mutable absl::Mutex mutex_;
  absl::CondVar changed_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Duration drain_deadline_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteDuration();
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status result_ ABSL_GUARDED_BY(mutex_);
  int registrations_ ABSL_GUARDED_BY(mutex_) = 0;
  grpc::ClientContext* register_context_ ABSL_GUARDED_BY(mutex_) = nullptr;
  Connection* connection_ ABSL_GUARDED_BY(mutex_) = nullptr;
  std::thread thread_;
};

}  // namespace shutterline::worker
