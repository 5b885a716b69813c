#include "server/api/watch_reactor.h"

#include "server/api/messages.h"

namespace shutterline::server {

WatchReactor::WatchReactor(Farm& farm, WorkPool& pool, StreamLimits& limits, const v1::WatchRequest& request)
    : FollowingReactor(farm, pool, request.job_id()), seq_(request.after_seq()) {
  Start(limits.watches);
}

absl::StatusOr<std::optional<v1::JobEvent>> WatchReactor::Next(bool& ended) {
  const std::optional<JobChange> change = farm().NextChange(job_id(), seq_, ended);
  if (!change) return std::nullopt;
  seq_ = change->seq;
  return ToMessage(*change);
}

}  // namespace shutterline::server
