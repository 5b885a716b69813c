#pragma once

#include <cstdint>

#include "server/api/following_reactor.h"
#include "server/api/stream_limits.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::server {

/// One Watch call.
class WatchReactor final : public FollowingReactor<v1::JobEvent> {
 public:
  WatchReactor(Farm& farm, WorkPool& pool, StreamLimits& limits, const v1::WatchRequest& request);

 private:
  absl::StatusOr<std::optional<v1::JobEvent>> Next(bool& ended) override;

  uint64_t seq_;  ///< Of the last change that was told.
};

}  // namespace shutterline::server
