#include "client/job_watch.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace shutterline::client {
namespace {

/// One Watch stream. `after_seq` and `last` follow its events.
absl::Status ReadEvents(Connection& connection, const std::string& job_id, const OnJobEvent& on_event,
                        Backoff& backoff, uint64_t& after_seq, v1::Job& last) {
  grpc::ClientContext context;
  Interrupt::Guard guard(connection.options().interrupt, [&context] { context.TryCancel(); });
  v1::WatchRequest request;
  request.set_job_id(job_id);
  request.set_after_seq(after_seq);
  const auto reader = connection.jobs().Watch(&context, request);
  v1::JobEvent event;
  while (reader->Read(&event)) {
    backoff.Progress();
    // Events must not come twice: a coordinator that repeats one is passed over.
    if (event.seq() <= after_seq) continue;
    after_seq = event.seq();
    if (event.has_job()) last = event.job();
    if (const absl::Status status = on_event(event); !status.ok()) {
      context.TryCancel();
      static_cast<void>(reader->Finish());
      return status;
    }
  }
  SL_RETURN_IF_ERROR(convert::FromGrpc(reader->Finish()));
  // A stream that ends well before the job has ended: the coordinator is going away.
  if (!HasEnded(last.state())) return absl::UnavailableError("the stream ended before the job");
  return absl::OkStatus();
}

}  // namespace

bool HasEnded(v1::JobState state) {
  return state == v1::JOB_STATE_SUCCEEDED || state == v1::JOB_STATE_FAILED ||
         state == v1::JOB_STATE_CANCELLED || state == v1::JOB_STATE_PARTIAL;
}

absl::StatusOr<v1::Job> WatchJob(Connection& connection, const std::string& job_id,
                                 const OnJobEvent& on_event) {
  RetryPolicy policy = connection.options().retry;
  policy.patience = connection.options().watch_patience;
  Backoff backoff(policy, connection.options().interrupt);
  uint64_t after_seq = 0;
  v1::Job last;
  absl::Status from_caller;
  const OnJobEvent guarded = [&](const v1::JobEvent& event) {
    from_caller = on_event(event);
    return from_caller;
  };
  while (true) {
    const absl::Status status = ReadEvents(connection, job_id, guarded, backoff, after_seq, last);
    if (status.ok()) return last;
    // The caller's own failures are not the connection's.
    if (!from_caller.ok()) return from_caller;
    if (!connection.PauseAfter(backoff, status)) {
      return connection.Explain(status, absl::StrCat("watch job ", job_id));
    }
  }
}

}  // namespace shutterline::client
