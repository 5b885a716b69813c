#include "server/api/tiles_reactor.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/status_macros.h"

namespace shutterline::server {

TilesReactor::TilesReactor(Farm& farm, FrameThumbnails& thumbnails, WorkPool& pool, StreamLimits& limits,
                           const v1::TilesRequest& request)
    : FollowingReactor(farm, pool, request.job_id()), thumbnails_(thumbnails), request_(request) {
  Start(limits.watches);
}

absl::Status TilesReactor::FindNews(bool& ended) {
  if (request_.side() < 1 || request_.side() > uint32_t(kTileSize)) {
    return absl::InvalidArgumentError(
        absl::StrCat("side: is ", request_.side(), ", but must be 1 to ", kTileSize));
  }
  // First whether it has ended: what is there after that was there before.
  SL_ASSIGN_OR_RETURN(const JobSnapshot job, farm().Get(job_id()));
  SL_ASSIGN_OR_RETURN(const Farm::FrameView view, farm().ViewFrame(job_id(), request_.frame()));
  const bool finished = view.frame.state == FrameState::kFinished;
  ended = finished || HasEnded(job.state);
  const int side = int(request_.side());
  if (told_.empty()) told_.resize(size_t(view.frame.tiles_total));
  SL_ASSIGN_OR_RETURN(std::vector<FrameThumbnails::Tile> tiles,
                      finished ? thumbnails_.Finished(*view.spec, view.path, told_, side)
                               : thumbnails_.Unfinished(*view.spec, view.key, told_, side));
  for (FrameThumbnails::Tile& tile : tiles) {
    told_[tile.index] = true;
    news_.push_back(std::move(tile));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<v1::TileUpdate>> TilesReactor::Next(bool& ended) {
  if (news_.empty() && !complete_) SL_RETURN_IF_ERROR(FindNews(complete_));
  if (news_.empty()) {
    ended = complete_;
    return std::nullopt;
  }
  v1::TileUpdate update;
  for (size_t i = 0; i < kTilesPerMessage && !news_.empty(); ++i) {
    v1::TilePicture& picture = *update.add_tiles();
    picture.set_tile(news_.front().index);
    picture.mutable_rgba()->Add(news_.front().rgba.begin(), news_.front().rgba.end());
    news_.pop_front();
  }
  return update;
}

}  // namespace shutterline::server
