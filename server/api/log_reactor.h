#pragma once

#include <cstdint>

#include "server/api/download_reactor.h"
#include "server/control/farm.h"
#include "server/logs/job_logs.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::server {

/// One ReadLog call: a chunk is read on the pool and written, then the next, until one is empty.
class LogReactor final : public DownloadReactor<v1::LogChunk> {
 public:
  LogReactor(Farm& farm, const JobLogs& logs, WorkPool& pool, StreamLimits& limits,
             const v1::LogRequest& request);

 private:
  absl::Status Open() override;
  absl::StatusOr<bool> Next(v1::LogChunk& chunk) override;

  Farm& farm_;
  const JobLogs& logs_;
  const v1::LogRequest request_;
  uint64_t offset_;
};

}  // namespace shutterline::server
