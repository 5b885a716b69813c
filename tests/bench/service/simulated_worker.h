#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>
#include <grpcpp/grpcpp.h>

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "shutterline/v1/workers.grpc.pb.h"
#include "worker/loop/gather.h"

namespace shutterline::bench {

/// A worker of one slot, on a connection of its own, whose tiles take a fixed time and are the same bytes. It
/// does what the real one does, by the same rules (Gather, LeasesToAskFor): holds three leases and asks for
/// more with its results, gathers those for as long as the coordinator says, sends heartbeats. It renders
/// whatever has been revoked. Has no thread: gRPC's call it, and `later`, which runs a task at a time.
/// Thread-safe.
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
    int64_t batches = 0;  ///< They came in.
    int64_t credits = 0;  ///< Messages of credit alone.
    int64_t grants = 0;
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
  void Finished(absl::Time end);
  /// From `start` on: what has been lost until somebody came to simulate it does not count.
  void BeginTile(absl::Time start) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  uint32_t LeasesToAsk(bool along) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void AskForMore() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Whether a tile of that frame is still to be rendered.
  bool Holds(const std::string& job, int frame) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  /// Sends what is due, or looks again when it will be.
  void SendDue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SendBatch() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string* const pixels_;
  const absl::Duration tile_time_;
  const Later later_;
  const Clock& clock_ = Clock::System();
  std::unique_ptr<v1::Workers::Stub> stub_;
  v1::Welcome welcome_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<Results> results_;

  absl::Mutex mutex_;
  std::deque<v1::Grant> leases_ ABSL_GUARDED_BY(mutex_);  ///< With the tiles that are not rendered yet.
  std::map<uint64_t, int> live_ ABSL_GUARDED_BY(mutex_);  ///< By lease: tiles that are not acknowledged.
  struct Result {
    std::string job;
    int frame = 0;
    uint32_t tile = 0;
    uint64_t lease = 0;
  };
  std::deque<Result> finished_ ABSL_GUARDED_BY(mutex_);  ///< Not sent yet.
  std::deque<std::vector<uint64_t>> under_way_
      ABSL_GUARDED_BY(mutex_);                      ///< Batches: the leases of their tiles.
  worker::Gather gather_ ABSL_GUARDED_BY(mutex_);   ///< Of finished_.
  bool will_look_ ABSL_GUARDED_BY(mutex_) = false;  ///< SendDue is called later.
  bool heard_ ABSL_GUARDED_BY(mutex_) = false;
  uint32_t credit_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t batches_ ABSL_GUARDED_BY(mutex_) = 0;
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Time idle_since_ ABSL_GUARDED_BY(mutex_);
  Count count_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::bench
