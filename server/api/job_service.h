#pragma once

#include <utility>

#include "server/api/limits.h"
#include "server/api/stream_limits.h"
#include "server/assemble/frame_thumbnails.h"
#include "server/auth/authorizer.h"
#include "server/control/farm.h"
#include "server/control/work_pool.h"
#include "server/logs/job_logs.h"
#include "server/observe/timeline.h"
#include "shutterline/v1/jobs.grpc.pb.h"

namespace shutterline::server {

/// The Jobs service: translates, and passes on. Its parts outlive it.
class JobService final : public v1::Jobs::WithRawCallbackMethod_Submit<v1::Jobs::CallbackService> {
 public:
  struct Parts {
    Farm& farm;
    const Timeline& timeline;
    const JobLogs& logs;
    FrameThumbnails& thumbnails;
    Config config;
    CoordinatorIdentity identity;
    WorkPool& pool;         ///< For what is short.
    WorkPool& submit_pool;  ///< For scene imports.
    const Authorizer& authorizer;
    StreamLimits& limits;
  };
  explicit JobService(Parts parts) : parts_(std::move(parts)) {}

  grpc::ServerUnaryReactor* GetCapabilities(grpc::CallbackServerContext* context,
                                            const v1::CapabilitiesRequest*,
                                            v1::Capabilities* response) override;
  grpc::ServerUnaryReactor* Submit(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                   grpc::ByteBuffer* response) override;
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
  grpc::ServerWriteReactor<v1::TileUpdate>* ReadTiles(grpc::CallbackServerContext* context,
                                                      const v1::TilesRequest* request) override;
  grpc::ServerWriteReactor<v1::LogChunk>* ReadLog(grpc::CallbackServerContext* context,
                                                  const v1::LogRequest* request) override;
  grpc::ServerWriteReactor<v1::FrameTrace>* ReadTrace(grpc::CallbackServerContext* context,
                                                      const v1::TraceRequest* request) override;

 private:
  absl::StatusOr<JobSnapshot> DoControl(const v1::ControlRequest& request);
  /// The job with its specification and its quarantined tiles.
  absl::Status FillWhole(const JobSnapshot& job, v1::Job& response);
  absl::Status DoList(const v1::ListRequest& request, v1::ListResponse& response);

  const Parts parts_;
};

}  // namespace shutterline::server
