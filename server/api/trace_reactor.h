#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "server/api/download_reactor.h"
#include "server/control/farm.h"
#include "server/observe/timeline.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::server {

/// One ReadTrace call: the timelines of a job's frames, one after the other, in messages of bounded size.
class TraceReactor final : public DownloadReactor<v1::FrameTrace> {
 public:
  TraceReactor(Farm& farm, const Timeline& timeline, WorkPool& pool, StreamLimits& limits,
               const v1::TraceRequest& request);

 private:
  absl::Status Open() override;
  absl::StatusOr<bool> Next(v1::FrameTrace& message) override;

  Farm& farm_;
  const Timeline& timeline_;
  const v1::TraceRequest request_;
  std::deque<int> frames_;  ///< Still to be told.
  std::optional<FrameTimeline> current_;
  size_t told_ = 0;  ///< Tiles of the current one.
};

}  // namespace shutterline::server
