#pragma once

#include "server/api/stream_limits.h"
#include "server/config/config.h"
#include "server/control/farm.h"
#include "server/control/result_committer.h"
#include "shutterline/v1/workers.grpc.pb.h"

namespace shutterline::server {

/// The Workers service over a Farm and a ResultCommitter, which outlive it.
class WorkerService final
    : public v1::Workers::WithCallbackMethod_Register<v1::Workers::WithRawCallbackMethod_Session<
          v1::Workers::WithRawCallbackMethod_PushResults<v1::Workers::Service>>> {
 public:
  WorkerService(Farm& farm, ResultCommitter& committer, const Config& config, StreamLimits& limits)
      : farm_(farm), committer_(committer), config_(config), limits_(limits) {}

  grpc::ServerUnaryReactor* Register(grpc::CallbackServerContext* context, const v1::Hello* request,
                                     v1::Welcome* response) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Session(
      grpc::CallbackServerContext* context) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* PushResults(
      grpc::CallbackServerContext* context) override;

 private:
  Farm& farm_;
  ResultCommitter& committer_;
  const Config config_;
  StreamLimits& limits_;
};

}  // namespace shutterline::server
