#include "server/api/log_reactor.h"

#include "proto/convert/status.h"
#include "server/api/limits.h"

namespace shutterline::server {

LogReactor::LogReactor(Farm& farm, const JobLogs& logs, WorkPool& pool, StreamLimits& limits,
                       const v1::LogRequest& request)
    : farm_(farm), logs_(logs), pool_(pool), request_(request), offset_(request.offset()) {
  if (const absl::Status taken = slot_.Take(limits.downloads); !taken.ok()) {
    Finish(convert::ToGrpc(taken));
    return;
  }
  if (!pool_.Run([this] { Begin(); })) {
    Finish(grpc::Status(grpc::StatusCode::UNAVAILABLE, "the coordinator is stopping"));
  }
}

void LogReactor::Begin() {
  const absl::Status known = farm_.Get(request_.job_id()).status();
  if (!known.ok()) return Finish(convert::ToGrpc(known));
  Next();
}

void LogReactor::Next() {
  absl::StatusOr<std::string> data = logs_.Read(request_.job_id(), offset_, kChunkBytes);
  if (!data.ok()) return Finish(convert::ToGrpc(data.status()));
  if (data->empty()) return Finish(grpc::Status::OK);
  chunk_.set_offset(offset_);
  offset_ += data->size();
  chunk_.set_data(*std::move(data));
  StartWrite(&chunk_);
}

void LogReactor::OnWriteDone(bool ok) {
  if (!ok) return Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the reader went away"));
  if (!pool_.Run([this] { Next(); })) {
    Finish(grpc::Status(grpc::StatusCode::UNAVAILABLE, "the coordinator is stopping"));
  }
}

}  // namespace shutterline::server
