#pragma once

#include <grpcpp/server_context.h>

#include <cstdint>
#include <optional>

#include "server/api/stream_limits.h"
#include "server/control/farm.h"
#include "server/control/work_pool.h"
#include "server/files/file.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::server {

/// One FetchFrame call: a chunk is read on the pool and written, then the next.
class FetchReactor final : public grpc::ServerWriteReactor<v1::FrameChunk> {
 public:
  FetchReactor(Farm& farm, WorkPool& pool, StreamLimits& limits, const v1::FrameRequest& request);

  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  absl::Status Open();
  void Next();

  Farm& farm_;
  WorkPool& pool_;
  StreamBudget::Slot slot_;
  const v1::FrameRequest request_;
  std::optional<File> file_;
  uint64_t offset_ = 0, size_ = 0;
  v1::FrameChunk chunk_;
};

}  // namespace shutterline::server
