#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "server/api/following_reactor.h"
#include "server/api/stream_limits.h"
#include "server/assemble/frame_thumbnails.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::server {

/// One ReadTiles call: each tile of a frame once, as soon as it is there.
class TilesReactor final : public FollowingReactor<v1::TileUpdate> {
 public:
  TilesReactor(Farm& farm, FrameThumbnails& thumbnails, WorkPool& pool, StreamLimits& limits,
               const v1::TilesRequest& request);

 private:
  static constexpr size_t kTilesPerMessage = 64;

  absl::StatusOr<std::optional<v1::TileUpdate>> Next(bool& ended) override;
  /// Tiles that have not been told of and can be.
  absl::Status FindNews(bool& ended);

  FrameThumbnails& thumbnails_;
  const v1::TilesRequest request_;
  std::vector<bool> told_;  ///< By tile; empty before the first look.
  std::deque<FrameThumbnails::Tile> news_;
  bool complete_ = false;  ///< There will be no more news.
};

}  // namespace shutterline::server
