#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>
#include <grpcpp/grpcpp.h>

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/asset/digest.h"
#include "shutterline/v1/blobs.grpc.pb.h"
#include "shutterline/v1/workers.grpc.pb.h"

namespace shutterline::worker {

/// A coordinator that does what a test tells it and records what workers say. In-process. Thread-safe.
class FakeCoordinator final : private v1::Workers::Service, private v1::Blobs::Service {
 public:
  FakeCoordinator();
  ~FakeCoordinator() override;

  std::shared_ptr<grpc::Channel> Channel();

  // --- What it answers: set before the worker starts, or under way -----------------------------
  void AnswerRegister(std::function<grpc::Status(const v1::Hello&)> answer);
  void AnswerOpen(std::function<grpc::Status(const v1::Open&)> answer);
  void Acknowledge(bool on);  ///< Whether batches are acknowledged as they come. Initially true.
  void SetOutcome(v1::ResultAck::Outcome outcome);
  Digest PutBlob(const std::string& bytes);
  void SetHeartbeatInterval(absl::Duration interval);
  /// Says in Welcome how long results are gathered, and that credit may come with them.
  void SetGather(absl::Duration gather);
  /// Says in acknowledgements how long results are gathered.
  void SetGatherOfAcks(absl::Duration gather);

  // --- What it says ------------------------------------------------------------------------------
  /// On the current Session stream; waits for one.
  void Send(const v1::CoordinatorMessage& message);
  void SendJob(const std::string& id, int width, int height, const Digest& scene);
  void Grant(uint64_t lease, const std::string& job, int frame, const std::vector<uint32_t>& tiles,
             bool send_at_once = false);
  /// Breaks all streams that are open now.
  void BreakStreams();

  // --- What it heard -----------------------------------------------------------------------------
  struct State {
    std::vector<v1::Hello> hellos;
    std::vector<v1::Open> opens;
    std::vector<v1::TileResult> results;  ///< In order of arrival, over all streams.
    std::vector<uint64_t> result_epochs;  ///< Of the batch of each result.
    std::vector<std::vector<uint64_t>> heartbeats;
    std::vector<uint64_t> returned;
    std::vector<int> batches;          ///< Results in each, in order of arrival.
    uint64_t credit = 0;               ///< Of the current stream.
    uint64_t credit_with_results = 0;  ///< Of all streams.
    int draining = 0;
    int sessions = 0;  ///< Session streams opened.
    int sessions_open = 0;
  };
  /// Waits (at most a minute) until `done` holds and returns the state. Fails the test otherwise.
  State WaitFor(const std::function<bool(const State&)>& done);
  State state();

 private:
  grpc::Status Register(grpc::ServerContext*, const v1::Hello* hello, v1::Welcome* welcome) override;
  grpc::Status Session(grpc::ServerContext* context,
                       grpc::ServerReaderWriter<v1::CoordinatorMessage, v1::WorkerMessage>* stream) override;
  grpc::Status PushResults(grpc::ServerContext* context,
                           grpc::ServerReaderWriter<v1::ResultAck, v1::ResultBatch>* stream) override;
  grpc::Status Read(grpc::ServerContext*, const v1::ReadRequest* request,
                    grpc::ServerWriter<v1::BlobChunk>* writer) override;

  absl::Mutex mutex_;
  State state_ ABSL_GUARDED_BY(mutex_);
  std::function<grpc::Status(const v1::Hello&)> answer_register_ ABSL_GUARDED_BY(mutex_);
  std::function<grpc::Status(const v1::Open&)> answer_open_ ABSL_GUARDED_BY(mutex_);
  bool acknowledge_ ABSL_GUARDED_BY(mutex_) = true;
  v1::ResultAck::Outcome outcome_ ABSL_GUARDED_BY(mutex_) = v1::ResultAck::OUTCOME_STORED;
  absl::Duration heartbeat_interval_ ABSL_GUARDED_BY(mutex_) = absl::Milliseconds(20);
  std::optional<absl::Duration> gather_ ABSL_GUARDED_BY(mutex_), ack_gather_ ABSL_GUARDED_BY(mutex_);
  uint64_t epoch_ ABSL_GUARDED_BY(mutex_) = 100;
  std::map<std::string, std::string> blobs_ ABSL_GUARDED_BY(mutex_);  // By raw digest.
  std::vector<grpc::ServerContext*> streams_ ABSL_GUARDED_BY(mutex_);
  grpc::ServerReaderWriter<v1::CoordinatorMessage, v1::WorkerMessage>* current_ ABSL_GUARDED_BY(mutex_) =
      nullptr;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace shutterline::worker
