#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>
#include <grpcpp/grpcpp.h>

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "shutterline/v1/workers.grpc.pb.h"

namespace shutterline::bench {

/// A worker of one slot, on a connection of its own, whose tiles take a fixed time and are the same bytes. It
/// does what the real one does: holds three leases, asks for more when fewer than two are left, sends
/// heartbeats. Has no thread: gRPC's call it, and `later`, which runs a task at a time. Thread-safe.
class SimulatedWorker {
 public:
  using Later = std::function<void(absl::Time, std::function<void()>)>;
  SimulatedWorker(const std::string& address, const std::string& uuid, const std::string* pixels,
                  absl::Duration tile_time, Later later);
  ~SimulatedWorker();  ///< After Stop.

  void Start();
  /// Breaks both streams and waits for their ends.
  void Stop();

  /// Idle time and tiles are counted from now on.
  void BeginCount();
  struct Count {
    absl::Duration idle;
    int64_t tiles = 0;    ///< Acknowledged.
    bool broken = false;  ///< A stream has ended.
  };
  Count EndCount();

 private:
  template <typename Request, typename Response>
  class Stream;
  using Session = Stream<v1::WorkerMessage, v1::CoordinatorMessage>;
  using Results = Stream<v1::ResultBatch, v1::ResultAck>;

  void OnMessage(const v1::CoordinatorMessage& message);
  void OnAck(const v1::ResultAck& ack);
  void Heartbeat();
  void Finished(const v1::Grant& tile);
  void BeginTile(absl::Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void AskForMore() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string* const pixels_;
  const absl::Duration tile_time_;
  const Later later_;
  std::unique_ptr<v1::Workers::Stub> stub_;
  v1::Welcome welcome_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<Results> results_;

  absl::Mutex mutex_;
  std::deque<v1::Grant> leases_ ABSL_GUARDED_BY(mutex_);  ///< With the tiles that are not rendered yet.
  uint32_t credit_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t batches_ ABSL_GUARDED_BY(mutex_) = 0;
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Time idle_since_ ABSL_GUARDED_BY(mutex_);
  Count count_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::bench
