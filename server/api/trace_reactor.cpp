#include "server/api/trace_reactor.h"

#include <algorithm>

#include "common/base/status_macros.h"
#include "proto/convert/status.h"

namespace shutterline::server {
namespace {

constexpr size_t kMaxTraceTiles = 1024;  ///< Of a message.

}  // namespace

TraceReactor::TraceReactor(Farm& farm, const Timeline& timeline, WorkPool& pool, StreamLimits& limits,
                           const v1::TraceRequest& request)
    : DownloadReactor(pool), farm_(farm), timeline_(timeline), request_(request) {
  Start(limits);
}

absl::Status TraceReactor::Open() {
  if (request_.has_frame()) {
    SL_RETURN_IF_ERROR(farm_.ViewFrame(request_.job_id(), request_.frame()).status());
    frames_ = {request_.frame()};
    return absl::OkStatus();
  }
  SL_RETURN_IF_ERROR(farm_.Get(request_.job_id()).status());
  const std::vector<int> frames = timeline_.Frames(request_.job_id());
  frames_.assign(frames.begin(), frames.end());
  return absl::OkStatus();
}

absl::StatusOr<bool> TraceReactor::Next(v1::FrameTrace& message) {
  while (!current_) {
    if (frames_.empty()) return false;
    current_ = timeline_.Find(request_.job_id(), frames_.front());
    if (!current_) frames_.pop_front();
  }
  message.set_frame(frames_.front());
  if (told_ == 0) {
    for (const FrameTimeline::Worker& worker : current_->workers) {
      v1::FrameTrace::Worker& added = *message.add_workers();
      added.set_uuid(worker.uuid);
      added.set_name(worker.name);
    }
  }
  const size_t end = std::min(current_->tiles.size(), told_ + kMaxTraceTiles);
  for (; told_ < end; ++told_) {
    const FrameTimeline::Tile& tile = current_->tiles[told_];
    v1::FrameTrace::Tile& added = *message.add_tiles();
    added.set_tile(tile.tile);
    added.set_worker(tile.worker);
    added.set_lease_id(tile.lease);
    *added.mutable_granted() = convert::ToProto(tile.granted);
    *added.mutable_received() = convert::ToProto(tile.received);
    *added.mutable_durable() = convert::ToProto(tile.durable);
    *added.mutable_render_time() = convert::ToProto(tile.render_time);
  }
  if (told_ == current_->tiles.size()) {
    if (current_->assembly) {
      *message.mutable_assembly_began() = convert::ToProto(current_->assembly->first);
      *message.mutable_assembly_ended() = convert::ToProto(current_->assembly->second);
    }
    current_.reset();
    frames_.pop_front();
    told_ = 0;
  }
  return true;
}

}  // namespace shutterline::server
