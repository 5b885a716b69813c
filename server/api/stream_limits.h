#pragma once

#include "server/api/stream_budget.h"
#include "server/api/stream_deadlines.h"
#include "server/api/upload_quota.h"
#include "server/config/config.h"

namespace shutterline::server {

/// What streams may take of the coordinator, all together. Outlives the services. Thread-safe.
struct StreamLimits {
  StreamLimits(const StreamConfig& given, const Clock& clock)
      : config(given),
        deadlines(clock),
        sessions("Session", given.max_sessions),
        results("PushResults", given.max_sessions),
        watches("Watch and ReadTiles", given.max_watches),
        uploads("Write", given.max_uploads),
        downloads("Read, FetchFrame, ReadLog and ReadTrace", given.max_downloads),
        upload_quota(given.max_uploading_bytes) {}

  const StreamConfig config;
  StreamDeadlines deadlines;
  StreamBudget sessions, results, watches, uploads, downloads;
  UploadQuota upload_quota;
};

}  // namespace shutterline::server
