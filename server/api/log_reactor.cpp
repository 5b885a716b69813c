#include "server/api/log_reactor.h"

#include <utility>

#include "common/base/status_macros.h"
#include "server/api/limits.h"

namespace shutterline::server {

LogReactor::LogReactor(Farm& farm, const JobLogs& logs, WorkPool& pool, StreamLimits& limits,
                       const v1::LogRequest& request)
    : DownloadReactor(pool), farm_(farm), logs_(logs), request_(request), offset_(request.offset()) {
  Start(limits);
}

absl::Status LogReactor::Open() {
  return farm_.Get(request_.job_id()).status();
}

absl::StatusOr<bool> LogReactor::Next(v1::LogChunk& chunk) {
  SL_ASSIGN_OR_RETURN(std::string data, logs_.Read(request_.job_id(), offset_, kChunkBytes));
  if (data.empty()) return false;
  chunk.set_offset(offset_);
  offset_ += data.size();
  chunk.set_data(std::move(data));
  return true;
}

}  // namespace shutterline::server
