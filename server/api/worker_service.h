#pragma once

#include "server/config/config.h"
#include "server/control/farm.h"
#include "server/control/result_committer.h"
#include "shutterline/v1/workers.grpc.pb.h"

namespace shutterline::server {

/// The Workers service over a Farm and a ResultCommitter, which outlive it.
class WorkerService final : public v1::Workers::CallbackService {
 public:
  WorkerService(Farm& farm, ResultCommitter& committer, const Config& config)
      : farm_(farm), committer_(committer), config_(config) {}

  grpc::ServerUnaryReactor* Register(grpc::CallbackServerContext* context, const v1::Hello* request,
                                     v1::Welcome* response) override;
  grpc::ServerBidiReactor<v1::WorkerMessage, v1::CoordinatorMessage>* Session(
      grpc::CallbackServerContext* context) override;
  grpc::ServerBidiReactor<v1::ResultBatch, v1::ResultAck>* PushResults(
      grpc::CallbackServerContext* context) override;

 private:
  Farm& farm_;
  ResultCommitter& committer_;
  const Config config_;
};

}  // namespace shutterline::server
