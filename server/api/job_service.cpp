#include "server/api/job_service.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <limits>

#include "common/base/status_macros.h"
#include "proto/convert/job_spec.h"
#include "server/api/fetch_reactor.h"
#include "server/api/log_reactor.h"
#include "server/api/messages.h"
#include "server/api/tiles_reactor.h"
#include "server/api/trace_reactor.h"
#include "server/api/unary.h"
#include "server/api/watch_reactor.h"
#include "server/api/wire.h"

namespace shutterline::server {

grpc::ServerUnaryReactor* JobService::GetCapabilities(grpc::CallbackServerContext* context,
                                                      const v1::CapabilitiesRequest*,
                                                      v1::Capabilities* response) {
  *response = CapabilitiesOf(parts_.config, parts_.identity, parts_.farm.epoch());
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerUnaryReactor* JobService::Submit(grpc::CallbackServerContext* context,
                                             const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return AnswerFrom(parts_.submit_pool, context, [this, context, request, response]() -> absl::Status {
    v1::SubmitRequest wish;
    SL_RETURN_IF_ERROR(Decode(*request, wish));
    SL_ASSIGN_OR_RETURN(const JobSpec spec, convert::FromProto(wish.spec(), parts_.config.job_limits));
    JobWishes wishes = WishesOf(wish);
    // Who has shown who it is pays for its jobs; others are taken at their word.
    const Caller caller = parts_.authorizer.CallerOf(*context);
    if (!caller.name.empty()) wishes.user = caller.name;
    SL_ASSIGN_OR_RETURN(const JobSnapshot job, parts_.farm.Submit(wish.request_id(), spec, wishes));
    *response = Encode(ToMessage(job, SpecDetail::kFull));
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* JobService::Get(grpc::CallbackServerContext* context, const v1::JobRef* request,
                                          v1::Job* response) {
  return AnswerFrom(parts_.pool, context, [this, request, response]() -> absl::Status {
    SL_ASSIGN_OR_RETURN(const JobSnapshot job, parts_.farm.Get(request->job_id()));
    return FillWhole(job, *response);
  });
}

absl::Status JobService::DoList(const v1::ListRequest& request, v1::ListResponse& response) {
  uint64_t before = std::numeric_limits<int64_t>::max();
  if (!request.page_token().empty() && !absl::SimpleAtoi(request.page_token(), &before)) {
    return absl::InvalidArgumentError("page_token: is none of ours");
  }
  if (request.page_size() > kMaxPageSize) {
    return absl::InvalidArgumentError(
        absl::StrCat("page_size: is ", request.page_size(), ", but at most ", kMaxPageSize, " may be"));
  }
  const int size = int(request.page_size() == 0 ? kDefaultPageSize : request.page_size());
  SL_ASSIGN_OR_RETURN(const std::vector<JobSnapshot> jobs, parts_.farm.List(before, size + 1));
  for (size_t i = 0; i < std::min(jobs.size(), size_t(size)); ++i) {
    *response.add_jobs() = ToMessage(jobs[i], SpecDetail::kWithoutFiles);
  }
  if (jobs.size() > size_t(size)) response.set_next_page_token(absl::StrCat(jobs[size_t(size) - 1].key));
  return absl::OkStatus();
}

grpc::ServerUnaryReactor* JobService::List(grpc::CallbackServerContext* context,
                                           const v1::ListRequest* request, v1::ListResponse* response) {
  return AnswerFrom(parts_.pool, context, [this, request, response] { return DoList(*request, *response); });
}

grpc::ServerUnaryReactor* JobService::Control(grpc::CallbackServerContext* context,
                                              const v1::ControlRequest* request, v1::Job* response) {
  return AnswerFrom(parts_.pool, context, [this, request, response]() -> absl::Status {
    SL_ASSIGN_OR_RETURN(const JobSnapshot job, DoControl(*request));
    if (request->action() == v1::ControlRequest::ACTION_REMOVE) {
      *response = ToMessage(job, SpecDetail::kFull);  // There is no more to be known of it.
      return absl::OkStatus();
    }
    return FillWhole(job, *response);
  });
}

absl::StatusOr<JobSnapshot> JobService::DoControl(const v1::ControlRequest& request) {
  switch (request.action()) {
    case v1::ControlRequest::ACTION_CANCEL:
      return parts_.farm.Cancel(request.job_id());
    case v1::ControlRequest::ACTION_PAUSE:
      return parts_.farm.SetPaused(request.job_id(), true);
    case v1::ControlRequest::ACTION_RESUME:
      return parts_.farm.SetPaused(request.job_id(), false);
    case v1::ControlRequest::ACTION_RETRY:
      return parts_.farm.Retry(request.job_id());
    case v1::ControlRequest::ACTION_REMOVE:
      return parts_.farm.Remove(request.job_id());
    case v1::ControlRequest::ACTION_SET_PRIORITY:
      return parts_.farm.SetPriority(request.job_id(), request.priority());
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("action: value ", int(request.action()), " is not known or not specified"));
  }
}

absl::Status JobService::FillWhole(const JobSnapshot& job, v1::Job& response) {
  response = ToMessage(job, SpecDetail::kFull);
  SL_ASSIGN_OR_RETURN(const std::vector<QuarantinedTile> quarantined,
                      parts_.farm.QuarantinedTiles(job.id, kMaxToldQuarantined));
  AddQuarantined(quarantined, response);
  return absl::OkStatus();
}

grpc::ServerUnaryReactor* JobService::ListWorkers(grpc::CallbackServerContext* context,
                                                  const v1::ListWorkersRequest*,
                                                  v1::ListWorkersResponse* response) {
  return AnswerFrom(parts_.pool, context, [this, response] {
    for (const WorkerSnapshot& worker : parts_.farm.Workers()) *response->add_workers() = ToMessage(worker);
    return absl::OkStatus();
  });
}

grpc::ServerWriteReactor<v1::JobEvent>* JobService::Watch(grpc::CallbackServerContext*,
                                                          const v1::WatchRequest* request) {
  return new WatchReactor(parts_.farm, parts_.pool, parts_.limits, *request);  // Frees itself in OnDone.
}

grpc::ServerWriteReactor<v1::FrameTrace>* JobService::ReadTrace(grpc::CallbackServerContext*,
                                                                const v1::TraceRequest* request) {
  // Frees itself in OnDone.
  return new TraceReactor(parts_.farm, parts_.timeline, parts_.pool, parts_.limits, *request);
}

grpc::ServerWriteReactor<v1::FrameChunk>* JobService::FetchFrame(grpc::CallbackServerContext*,
                                                                 const v1::FrameRequest* request) {
  return new FetchReactor(parts_.farm, parts_.pool, parts_.limits, *request);  // Frees itself in OnDone.
}

grpc::ServerWriteReactor<v1::TileUpdate>* JobService::ReadTiles(grpc::CallbackServerContext*,
                                                                const v1::TilesRequest* request) {
  // Frees itself in OnDone.
  return new TilesReactor(parts_.farm, parts_.thumbnails, parts_.pool, parts_.limits, *request);
}

grpc::ServerWriteReactor<v1::LogChunk>* JobService::ReadLog(grpc::CallbackServerContext*,
                                                            const v1::LogRequest* request) {
  // Frees itself in OnDone.
  return new LogReactor(parts_.farm, parts_.logs, parts_.pool, parts_.limits, *request);
}

}  // namespace shutterline::server
