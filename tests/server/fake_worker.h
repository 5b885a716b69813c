#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "shutterline/v1/workers.grpc.pb.h"

namespace shutterline::test {

/// The pixels that a scripted worker makes for a tile: a function of frame and position alone.
std::string SyntheticTile(int width, int height, int frame, uint32_t tile);
/// What SyntheticTile puts at a pixel, R, G, B, A.
void SyntheticPixel(int frame, int x, int y, float pixels[4]);

/// A worker that does what a test says, one step at a time; calls block until the coordinator has answered.
class FakeWorker {
 public:
  /// `held`: what it says it is at since an earlier session.
  explicit FakeWorker(const std::shared_ptr<grpc::Channel>& channel, const std::string& uuid = "fake",
                      const std::vector<v1::HeldLease>& held = {});
  /// A worker that says this of itself.
  FakeWorker(const std::shared_ptr<grpc::Channel>& channel, const v1::Hello& hello,
             const std::vector<v1::HeldLease>& held = {});
  ~FakeWorker();  ///< Dies.

  static v1::Hello MakeHello(const std::string& uuid);
  const v1::Welcome& welcome() const { return welcome_; }

  void Credit(uint32_t leases);
  void Heartbeat(const std::vector<uint64_t>& leases);
  void Return(const std::vector<uint64_t>& leases);
  /// The next message of the session stream; false at its end, whose status is then known.
  bool Next(v1::CoordinatorMessage& message);
  /// The next grant; messages before it are passed over, but for jobs, which are kept in `job`.
  v1::Grant NextGrant();
  /// Sends one batch and returns its acknowledgement.
  v1::ResultAck Push(const std::vector<v1::TileResult>& results, uint32_t credit = 0);
  /// Renders and pushes a whole grant.
  v1::ResultAck Render(const v1::Grant& grant, uint32_t credit = 0);
  v1::TileResult Result(const v1::Grant& grant, uint32_t tile) const;
  /// Asks for a lease and fails the tiles of it.
  void FailNext(const std::string& reason);
  /// Grants and renders with one credit after the other until the job is to be forgotten.
  void RenderUntilForgotten();
  /// The process is gone: both streams break.
  void Die();
  /// Closes both streams in order and returns their statuses.
  std::pair<grpc::Status, grpc::Status> Leave();
  grpc::Status SessionStatus();

  v1::JobDetails job;

 private:
  std::unique_ptr<v1::Workers::Stub> stub_;
  v1::Welcome welcome_;
  grpc::ClientContext session_context_, results_context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::WorkerMessage, v1::CoordinatorMessage>> session_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ResultBatch, v1::ResultAck>> results_;
  uint64_t next_batch_ = 1;
  bool gone_ = false;
};

}  // namespace shutterline::test
