#include "server/http/to_json.h"

#include <absl/time/time.h>

#include <cmath>

#include "server/jobs/job_state_words.h"

namespace shutterline::server {
namespace {

Json OrNull(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

Json TimeOf(absl::Time time) {
  if (time == absl::InfinitePast() || time == absl::InfiniteFuture()) return nullptr;
  return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", time, absl::UTCTimeZone());
}

const char* FrameStateWord(FrameState state) {
  switch (state) {
    case FrameState::kQueued:
      return "queued";
    case FrameState::kRunning:
      return "running";
    case FrameState::kFinished:
      return "finished";
  }
  return "unknown";
}

/// Microseconds are exact enough for people, and short.
double Rounded(double seconds) {
  return std::round(seconds * 1e6) / 1e6;
}

}  // namespace

Json ToJson(const JobSnapshot& job) {
  const JobSpec& spec = *job.spec;
  return {{"id", job.id},
          {"name", spec.name},
          {"scene", spec.scene.root_name},
          {"state", std::string(JobStateWord(job.state))},
          {"error", job.error},
          {"frames_total", job.frames_total},
          {"frames_finished", job.frames_finished},
          {"tiles_total", job.tiles_total},
          {"tiles_done", job.tiles_done},
          {"mismatched_tiles", job.mismatched_tiles},
          {"tiles_quarantined", job.tiles_quarantined},
          {"paused", job.paused},
          {"priority", job.wishes.priority},
          {"user", job.wishes.user},
          {"waits_for", job.waits_for},
          {"submitted", TimeOf(job.submitted)},
          {"ended", HasEnded(job.state) ? TimeOf(job.ended) : Json(nullptr)},
          {"first", spec.frames.first},
          {"last", spec.frames.last},
          {"step", spec.frames.step},
          {"width", spec.render.width},
          {"height", spec.render.height},
          {"order", std::string(ToString(spec.order))},
          {"workers", job.workers}};
}

Json ToJson(const FrameSnapshot& frame) {
  const bool finished = frame.state == FrameState::kFinished;
  return {
      {"frame", frame.frame},
      {"state", FrameStateWord(frame.state)},
      {"tiles_total", frame.tiles_total},
      {"tiles_done", frame.tiles_done},
      {"tiles_missing", frame.tiles_missing},
      {"digest", finished ? Json(frame.digest.ToHex()) : Json(nullptr)},
      {"size_bytes", finished ? Json(frame.size) : Json(nullptr)},
      {"thread_seconds", frame.stats.tiles > 0 ? Json(Rounded(frame.stats.TotalSeconds())) : Json(nullptr)}};
}

Json ToJson(const QuarantinedTile& tile) {
  Json evidence = Json::array();
  for (const TileTrouble& trouble : tile.evidence) {
    evidence.push_back({{"worker_uuid", trouble.worker_uuid},
                        {"worker_name", trouble.worker_name},
                        {"worker_ended", trouble.worker_ended},
                        {"reason", trouble.reason},
                        {"signal", OrNull(trouble.signal)},
                        {"log_tail", OrNull(trouble.log_tail)},
                        {"time", TimeOf(trouble.when)}});
  }
  return {{"frame", tile.frame}, {"tile", tile.tile}, {"evidence", evidence}};
}

Json ToJson(const WorkerSnapshot& worker) {
  return {{"uuid", worker.uuid},
          {"name", worker.name},
          {"build", worker.build_id},
          {"isa", worker.isa},
          {"slots", worker.slots},
          {"draining", worker.draining},
          {"leased_tiles", worker.leased_tiles},
          {"tiles_done", worker.tiles_done},
          {"tile_seconds", worker.tile_time > absl::ZeroDuration()
                               ? Json(Rounded(absl::ToDoubleSeconds(worker.tile_time)))
                               : Json(nullptr)},
          {"silent_seconds", Rounded(absl::ToDoubleSeconds(worker.silent))}};
}

Json ToJson(const FarmTotals& totals) {
  Json jobs = Json::object();
  for (const JobState state : kJobStates) {
    if (HasEnded(state)) continue;
    const auto found = totals.jobs.find(state);
    jobs[std::string(JobStateWord(state))] = found == totals.jobs.end() ? 0 : found->second;
  }
  return {{"workers", totals.workers},
          {"draining_workers", totals.draining_workers},
          {"slots", totals.slots},
          {"jobs", jobs},
          {"queued_tiles", totals.queued_tiles},
          {"leased_tiles", totals.leased_tiles},
          {"remaining_seconds", Rounded(totals.remaining_seconds)}};
}

Json ToJson(const FrameTimeline& timeline) {
  Json tiles = Json::array(), workers = Json::array();
  for (const FrameTimeline::Tile& tile : timeline.tiles) {
    tiles.push_back({tile.tile, Rounded(absl::ToDoubleSeconds(tile.render_time)), tile.worker});
  }
  for (const FrameTimeline::Worker& worker : timeline.workers) workers.push_back(worker.name);
  return {{"workers", workers}, {"tiles", tiles}};
}

std::string Dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace shutterline::server
