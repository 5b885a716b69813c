#pragma once

#include <grpcpp/server_context.h>

#include <cstdint>

#include "server/api/stream_limits.h"
#include "server/control/farm.h"
#include "server/control/work_pool.h"
#include "server/logs/job_logs.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::server {

/// One ReadLog call: a chunk is read on the pool and written, then the next, until one is empty.
class LogReactor final : public grpc::ServerWriteReactor<v1::LogChunk> {
 public:
  LogReactor(Farm& farm, const JobLogs& logs, WorkPool& pool, StreamLimits& limits,
             const v1::LogRequest& request);

  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  void Begin();
  void Next();

  Farm& farm_;
  const JobLogs& logs_;
  WorkPool& pool_;
  StreamBudget::Slot slot_;
  const v1::LogRequest request_;
  uint64_t offset_;
  v1::LogChunk chunk_;
};

}  // namespace shutterline::server
