#include "server/http/event_stream.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "server/http/to_json.h"

namespace shutterline::server {
namespace {

constexpr size_t kMaxEvents = 64;  ///< At once.
constexpr absl::Duration kFarmInterval = absl::Seconds(1);

std::string Event(absl::string_view name, uint64_t id, const Json& data) {
  return absl::StrCat("id: ", id, "\nevent: ", name, "\ndata: ", Dump(data), "\n\n");
}

}  // namespace

bool StreamGate::Enter() {
  absl::MutexLock lock(&mutex_);
  if (closed_ || streams_ >= kMaxStreams) return false;
  ++streams_;
  return true;
}

void StreamGate::Leave() {
  absl::MutexLock lock(&mutex_);
  --streams_;
}

void StreamGate::Close() {
  absl::MutexLock lock(&mutex_);
  closed_ = true;
}

bool StreamGate::Wait(absl::Duration time) {
  absl::MutexLock lock(&mutex_);
  return !mutex_.AwaitWithTimeout(absl::Condition(&closed_), time);
}

EventStream::EventStream(Farm& farm, const Throughput& throughput, const Clock& clock, std::string job_id,
                         uint64_t after)
    : farm_(farm), throughput_(throughput), clock_(clock), job_id_(std::move(job_id)), after_(after) {}

std::string EventStream::JobEvents() {
  std::string text;
  if (job_id_.empty()) {
    for (const auto& [seq, job] : farm_.ChangedJobs(after_, kMaxEvents)) {
      absl::StrAppend(&text, Event("job", seq, ToJson(job)));
      after_ = seq;
    }
    return text;
  }
  for (size_t i = 0; i < kMaxEvents; ++i) {
    bool ended = false;
    const std::optional<JobChange> change = farm_.NextChange(job_id_, after_, ended);
    if (!change) break;
    after_ = change->seq;
    if (const auto* job = std::get_if<JobSnapshot>(&change->what)) {
      absl::StrAppend(&text, Event("job", change->seq, ToJson(*job)));
    } else {
      absl::StrAppend(&text, Event("frame", change->seq, ToJson(std::get<FrameSnapshot>(change->what))));
    }
  }
  return text;
}

std::string EventStream::FarmEvent() {
  Json farm = ToJson(farm_.Totals());
  farm["tiles_per_second"] = throughput_.TilesPerSecond();
  return absl::StrCat("event: farm\ndata: ", Dump(farm), "\n\n");
}

std::string EventStream::Next() {
  std::string text = JobEvents();
  if (clock_.Monotonic() >= next_farm_) {
    next_farm_ = clock_.Monotonic() + kFarmInterval;
    absl::StrAppend(&text, FarmEvent());
  }
  return text;
}

}  // namespace shutterline::server
