#pragma once

#include <grpcpp/server_context.h>

#include <cstddef>
#include <deque>
#include <optional>

#include "server/api/stream_limits.h"
#include "server/control/farm.h"
#include "server/control/work_pool.h"
#include "server/observe/timeline.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::server {

/// One ReadTrace call: the timelines of a job's frames, one after the other, in messages of bounded size.
class TraceReactor final : public grpc::ServerWriteReactor<v1::FrameTrace> {
 public:
  TraceReactor(Farm& farm, const Timeline& timeline, WorkPool& pool, StreamLimits& limits,
               const v1::TraceRequest& request);

  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  absl::Status Open();
  void Next();

  Farm& farm_;
  const Timeline& timeline_;
  WorkPool& pool_;
  StreamBudget::Slot slot_;
  const v1::TraceRequest request_;
  std::deque<int> frames_;  ///< Still to be told.
  std::optional<FrameTimeline> current_;
  size_t told_ = 0;  ///< Tiles of the current one.
  v1::FrameTrace message_;
};

}  // namespace shutterline::server
