#include "client/delivery.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <cerrno>
#include <set>
#include <utility>

#include "client/human.h"
#include "client/job_watch.h"
#include "common/base/status_macros.h"

namespace shutterline::client {

ExitCode Delivery::Code() const {
  if (job.state() == v1::JOB_STATE_SUCCEEDED) return ExitCode::kSuccess;
  return job.frames_finished() > 0 ? ExitCode::kPartial : ExitCode::kFailed;
}

absl::Status CheckDestination(const OutputPath& output) {
  const std::string& path = output.text();
  const size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  if (access(folder.c_str(), W_OK | X_OK) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("write ", path, ": folder ", folder));
  }
  return absl::OkStatus();
}

absl::StatusOr<Delivery> Deliver(Connection& connection, const std::string& job_id, const FrameRange& frames,
                                 const Destination* destination, Progress& progress) {
  Delivery delivery;
  std::set<int> here;
  const auto fetch = [&](int frame) -> absl::Status {
    if (destination == nullptr || !frames.IndexOf(frame) || !here.insert(frame).second) {
      return absl::OkStatus();
    }
    SL_ASSIGN_OR_RETURN(FetchedFrame fetched,
                        FetchFrame(connection, job_id, frame,
                                   destination->output.FrameFile(frame, frames.Count()), destination->png));
    delivery.frames.push_back(std::move(fetched));
    return absl::OkStatus();
  };

  SL_ASSIGN_OR_RETURN(delivery.job, WatchJob(connection, job_id, [&](const v1::JobEvent& event) {
                        if (event.has_job()) progress.Update(FactsOf(event.job()));
                        if (event.has_frame() && event.frame().state() == v1::FRAME_STATE_FINISHED) {
                          delivery.finished[event.frame().frame()] = event.frame();
                          return fetch(event.frame().frame());
                        }
                        return absl::OkStatus();
                      }));
  // These promise every frame, whatever the events said one by one.
  if (delivery.job.state() == v1::JOB_STATE_SUCCEEDED || delivery.job.state() == v1::JOB_STATE_PARTIAL) {
    for (int64_t index = 0; index < frames.Count(); ++index) {
      SL_RETURN_IF_ERROR(fetch(frames.Frame(index)));
    }
  }
  progress.Finish();
  return delivery;
}

std::string DescribeEnd(const v1::Job& job) {
  std::string text = absl::StrCat("job ", job.id(), " ", WordOf(job.state()));
  if (!HasEnded(job.state()) && job.paused()) absl::StrAppend(&text, ", paused");
  if (!job.error().empty()) absl::StrAppend(&text, ": ", Printable(job.error()));
  if (job.frames_finished() > 0) {
    absl::StrAppend(&text, " (", job.frames_finished(), " of ", job.frames_total(), " frames finished)");
  }
  return text;
}

ProgressFacts FactsOf(const v1::Job& job) {
  ProgressFacts facts;
  facts.state = WordOf(job.state());
  facts.done = static_cast<int64_t>(job.tiles_done());
  facts.total = static_cast<int64_t>(job.tiles_total());
  facts.frames_done = job.frames_finished();
  facts.frames_total = job.frames_total();
  if (HasEnded(job.state())) return facts;
  if (job.paused()) {
    facts.note = "paused";
  } else if (job.waits_for_size() > 0) {
    facts.note = absl::StrCat("waits for job ", Printable(job.waits_for(0)));
  } else if (job.workers() == 0) {
    facts.note = "no worker is connected";
  }
  return facts;
}

std::string WordOf(v1::JobState state) {
  switch (state) {
    case v1::JOB_STATE_QUEUED:
      return "queued";
    case v1::JOB_STATE_RUNNING:
      return "running";
    case v1::JOB_STATE_SUCCEEDED:
      return "succeeded";
    case v1::JOB_STATE_FAILED:
      return "failed";
    case v1::JOB_STATE_CANCELLED:
      return "cancelled";
    case v1::JOB_STATE_PARTIAL:
      return "partial";
    default:
      return "unknown";
  }
}

}  // namespace shutterline::client
