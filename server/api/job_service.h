#pragma once

#include "server/api/limits.h"
#include "server/control/farm.h"
#include "server/control/work_pool.h"
#include "server/observe/timeline.h"
#include "shutterline/v1/jobs.grpc.pb.h"

namespace shutterline::server {

/// The Jobs service over a Farm, which outlives it, as the pools do.
class JobService final : public v1::Jobs::CallbackService {
 public:
  /// `pool` for what is short, `submit_pool` for scene imports.
  JobService(Farm& farm, const Config& config, const CoordinatorIdentity& identity, WorkPool& pool,
             WorkPool& submit_pool, const Timeline& timeline)
      : farm_(farm),
        timeline_(timeline),
        config_(config),
        identity_(identity),
        pool_(pool),
        submit_pool_(submit_pool) {}

  grpc::ServerUnaryReactor* GetCapabilities(grpc::CallbackServerContext* context,
                                            const v1::CapabilitiesRequest*,
                                            v1::Capabilities* response) override;
  grpc::ServerUnaryReactor* Submit(grpc::CallbackServerContext* context, const v1::SubmitRequest* request,
                                   v1::Job* response) override;
  grpc::ServerUnaryReactor* Get(grpc::CallbackServerContext* context, const v1::JobRef* request,
                                v1::Job* response) override;
  grpc::ServerUnaryReactor* List(grpc::CallbackServerContext* context, const v1::ListRequest* request,
                                 v1::ListResponse* response) override;
  grpc::ServerUnaryReactor* Control(grpc::CallbackServerContext* context, const v1::ControlRequest* request,
                                    v1::Job* response) override;
  grpc::ServerUnaryReactor* ListWorkers(grpc::CallbackServerContext* context, const v1::ListWorkersRequest*,
                                        v1::ListWorkersResponse* response) override;
  grpc::ServerWriteReactor<v1::JobEvent>* Watch(grpc::CallbackServerContext* context,
                                                const v1::WatchRequest* request) override;
  grpc::ServerWriteReactor<v1::FrameChunk>* FetchFrame(grpc::CallbackServerContext* context,
                                                       const v1::FrameRequest* request) override;
  grpc::ServerWriteReactor<v1::FrameTrace>* ReadTrace(grpc::CallbackServerContext* context,
                                                      const v1::TraceRequest* request) override;

 private:
  absl::Status DoList(const v1::ListRequest& request, v1::ListResponse& response);

  Farm& farm_;
  const Timeline& timeline_;
  const Config config_;
  const CoordinatorIdentity identity_;
  WorkPool& pool_;
  WorkPool& submit_pool_;
};

}  // namespace shutterline::server
