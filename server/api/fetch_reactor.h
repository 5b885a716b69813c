#pragma once

#include <cstdint>
#include <optional>

#include "server/api/download_reactor.h"
#include "server/control/farm.h"
#include "server/files/file.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::server {

/// One FetchFrame call: a chunk is read on the pool and written, then the next.
class FetchReactor final : public DownloadReactor<v1::FrameChunk> {
 public:
  FetchReactor(Farm& farm, WorkPool& pool, StreamLimits& limits, const v1::FrameRequest& request);

 private:
  absl::Status Open() override;
  absl::StatusOr<bool> Next(v1::FrameChunk& chunk) override;
  std::optional<absl::Status> End() override;

  Farm& farm_;
  const v1::FrameRequest request_;
  std::optional<File> file_;
  Digest digest_;
  uint64_t offset_ = 0, size_ = 0;
};

}  // namespace shutterline::server
