#include "server/api/messages.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/status_macros.h"
#include "common/base/utf8.h"
#include "common/job/tile.h"
#include "proto/convert/job_spec.h"
#include "proto/convert/render_stats.h"
#include "proto/convert/status.h"
#include "server/api/limits.h"

namespace shutterline::server {
namespace {

v1::JobState ToMessage(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return v1::JOB_STATE_QUEUED;
    case JobState::kRunning:
      return v1::JOB_STATE_RUNNING;
    case JobState::kSucceeded:
      return v1::JOB_STATE_SUCCEEDED;
    case JobState::kFailed:
      return v1::JOB_STATE_FAILED;
    case JobState::kCancelled:
      return v1::JOB_STATE_CANCELLED;
    case JobState::kPartial:
      return v1::JOB_STATE_PARTIAL;
  }
  return v1::JOB_STATE_UNSPECIFIED;
}

v1::FrameState ToMessage(FrameState state) {
  switch (state) {
    case FrameState::kQueued:
      return v1::FRAME_STATE_QUEUED;
    case FrameState::kRunning:
      return v1::FRAME_STATE_RUNNING;
    case FrameState::kFinished:
      return v1::FRAME_STATE_FINISHED;
  }
  return v1::FRAME_STATE_UNSPECIFIED;
}

struct EventWriter {
  v1::CoordinatorMessage& message;

  void operator()(const JobAnnounced& event) const {
    v1::JobDetails& job = *message.mutable_job();
    job.set_job_id(event.job_id);
    *job.mutable_scene() = convert::ToProto(event.spec->scene);
    *job.mutable_render() = convert::ToProto(event.spec->render);
  }
  void operator()(const LeaseGranted& event) const {
    v1::Grant& grant = *message.mutable_grant();
    grant.set_lease_id(event.lease);
    grant.set_job_id(event.job_id);
    grant.set_frame(event.frame);
    grant.mutable_tiles()->Add(event.tiles.begin(), event.tiles.end());
    grant.set_adopts(event.adopts);
    grant.set_send_at_once(event.send_at_once);
  }
  void operator()(const LeasesRevoked& event) const {
    v1::Revoke& revoke = *message.mutable_revoke();
    revoke.mutable_lease_ids()->Add(event.leases.begin(), event.leases.end());
    for (const auto& [lease, tiles] : event.tiles) {
      v1::RevokedTiles& revoked = *revoke.add_tiles();
      revoked.set_lease_id(lease);
      revoked.mutable_tiles()->Add(tiles.begin(), tiles.end());
    }
  }
  void operator()(const JobForgotten& event) const { message.mutable_forget_job()->set_job_id(event.job_id); }
  void operator()(const DrainAsked&) const { message.mutable_drain(); }
  void operator()(const AllAdopted&) const { message.mutable_adopted(); }
};

}  // namespace

v1::Job ToMessage(const JobSnapshot& job, SpecDetail detail) {
  v1::Job message;
  message.set_id(job.id);
  if (detail == SpecDetail::kFull) {
    *message.mutable_spec() = convert::ToProto(*job.spec);
  } else if (detail == SpecDetail::kWithoutFiles) {
    JobSpec spec = *job.spec;
    spec.scene.files.clear();
    *message.mutable_spec() = convert::ToProto(spec);
  }
  message.set_state(ToMessage(job.state));
  message.set_error(job.error);
  message.set_frames_total(uint32_t(job.frames_total));
  message.set_frames_finished(uint32_t(job.frames_finished));
  message.set_tiles_total(uint64_t(job.tiles_total));
  message.set_tiles_done(uint64_t(job.tiles_done));
  *message.mutable_submitted() = convert::ToProto(job.submitted);
  if (HasEnded(job.state)) *message.mutable_ended() = convert::ToProto(job.ended);
  message.set_mismatched_tiles(uint64_t(job.mismatched_tiles));
  message.set_workers(uint32_t(job.workers));
  message.set_paused(job.paused);
  message.set_priority(job.wishes.priority);
  message.set_user(job.wishes.user);
  message.mutable_after()->Add(job.wishes.after.begin(), job.wishes.after.end());
  message.mutable_waits_for()->Add(job.waits_for.begin(), job.waits_for.end());
  message.set_tiles_quarantined(uint64_t(job.tiles_quarantined));
  return message;
}

void AddQuarantined(const std::vector<QuarantinedTile>& tiles, v1::Job& job) {
  for (const QuarantinedTile& tile : tiles) {
    v1::QuarantinedTile& message = *job.add_quarantined();
    message.set_frame(tile.frame);
    message.set_tile(tile.tile);
    for (const TileTrouble& trouble : tile.evidence) {
      v1::TileTrouble& evidence = *message.add_evidence();
      evidence.set_worker_uuid(trouble.worker_uuid);
      evidence.set_worker_name(trouble.worker_name);
      evidence.set_worker_ended(trouble.worker_ended);
      evidence.set_reason(trouble.reason);
      *evidence.mutable_time() = convert::ToProto(trouble.when);
      evidence.set_signal(trouble.signal);
      evidence.set_log_tail(trouble.log_tail);
    }
  }
}

v1::FrameStatus ToMessage(const FrameSnapshot& frame) {
  v1::FrameStatus message;
  message.set_frame(frame.frame);
  message.set_state(ToMessage(frame.state));
  message.set_tiles_total(uint32_t(frame.tiles_total));
  message.set_tiles_done(uint32_t(frame.tiles_done));
  if (frame.state == FrameState::kFinished) {
    *message.mutable_digest() = convert::ToProto(frame.digest);
    message.set_size_bytes(frame.size);
  }
  message.set_tiles_missing(uint32_t(frame.tiles_missing));
  if (frame.stats.tiles > 0) *message.mutable_stats() = convert::ToProto(frame.stats);
  return message;
}

v1::Worker ToMessage(const WorkerSnapshot& worker) {
  v1::Worker message;
  message.set_uuid(worker.uuid);
  message.set_name(worker.name);
  message.set_build_id(worker.build_id);
  message.set_isa(worker.isa);
  message.set_slots(uint32_t(worker.slots));
  message.set_draining(worker.draining);
  message.set_leased_tiles(uint64_t(worker.leased_tiles));
  message.set_tiles_done(uint64_t(worker.tiles_done));
  message.set_tile_seconds(absl::ToDoubleSeconds(worker.tile_time));
  message.set_silent_seconds(absl::ToDoubleSeconds(worker.silent));
  return message;
}

v1::JobEvent ToMessage(const JobChange& change) {
  v1::JobEvent message;
  message.set_seq(change.seq);
  if (const auto* job = std::get_if<JobSnapshot>(&change.what)) {
    *message.mutable_job() = ToMessage(*job, SpecDetail::kNone);
  } else {
    *message.mutable_frame() = ToMessage(std::get<FrameSnapshot>(change.what));
  }
  return message;
}

v1::CoordinatorMessage ToMessage(const WorkerEvent& event) {
  v1::CoordinatorMessage message;
  std::visit(EventWriter{message}, event);
  return message;
}

v1::Capabilities CapabilitiesOf(const Config& config, const CoordinatorIdentity& identity, uint64_t epoch) {
  v1::Capabilities message;
  message.mutable_protocol()->set_low(identity.protocol_low);
  message.mutable_protocol()->set_high(identity.protocol_high);
  message.set_build_id(identity.build_id);
  message.set_epoch(epoch);
  message.set_tile_size(kTileSize);
  message.set_max_frame_side(kMaxFrameSide);
  message.set_max_frames(uint32_t(config.job_limits.max_frames));
  message.set_max_tiles(uint64_t(config.job_limits.max_tiles));
  message.set_max_manifest_files(uint32_t(config.job_limits.max_manifest_files));
  message.set_max_blob_bytes(config.max_blob_bytes);
  message.set_max_name_bytes(uint32_t(config.job_limits.max_name_bytes));
  message.set_max_page_size(kMaxPageSize);
  message.set_max_digests(kMaxDigests);
  return message;
}

v1::ResultAck::Outcome ToMessage(ReportOutcome outcome) {
  switch (outcome) {
    case ReportOutcome::kStored:
      return v1::ResultAck::OUTCOME_STORED;
    case ReportOutcome::kDuplicate:
      return v1::ResultAck::OUTCOME_DUPLICATE;
    case ReportOutcome::kMismatch:
      return v1::ResultAck::OUTCOME_MISMATCH;
    case ReportOutcome::kUnwanted:
      return v1::ResultAck::OUTCOME_UNWANTED;
    case ReportOutcome::kRefused:
      return v1::ResultAck::OUTCOME_REFUSED;
  }
  return v1::ResultAck::OUTCOME_UNSPECIFIED;
}

JobWishes WishesOf(const v1::SubmitRequest& request) {
  return {request.priority(), request.user(), {request.after().begin(), request.after().end()}};
}

absl::StatusOr<std::vector<HeldLease>> HeldOf(const v1::Open& open) {
  if (open.held_size() > kMaxHeartbeatLeases) {
    return absl::InvalidArgumentError(absl::StrCat("open.held: has ", open.held_size(), " entries"));
  }
  std::vector<HeldLease> held;
  for (const v1::HeldLease& lease : open.held()) {
    if (lease.ticket() == 0) return absl::InvalidArgumentError("open.held: a ticket is 0");
    held.push_back(
        {lease.ticket(), lease.job_id(), lease.frame(), {lease.tiles().begin(), lease.tiles().end()}});
  }
  return held;
}

WorkerHello FromMessage(const v1::Hello& hello) {
  WorkerHello result;
  result.uuid = hello.worker_uuid();
  result.boot_id = hello.boot_id();
  result.build_id = hello.build_id();
  result.isa = hello.isa();
  result.name = hello.name();
  result.protocol_low = hello.protocol().low();
  result.protocol_high = hello.protocol().high();
  result.slots = hello.slots();
  for (const v1::WorkerExit& exit : hello.exits()) {
    WorkerExit& ended =
        result.exits.emplace_back(WorkerExit{exit.boot_id(), exit.signal(), exit.log_tail(), {}});
    for (const v1::TileName& tile : exit.tiles())
      ended.tiles.push_back({tile.job_id(), tile.frame(), tile.tile()});
  }
  return result;
}

absl::StatusOr<TileReport> TakeReport(v1::TileResult& result) {
  TileReport report;
  report.job_id = std::move(*result.mutable_job_id());
  report.frame = result.frame();
  report.tile = result.tile();
  report.render_time = convert::FromProto(result.render_time());
  SL_ASSIGN_OR_RETURN(
      report.stats, convert::FromProto(result.stats(), absl::StrCat("tiles: the result of tile ", report.tile,
                                                                    " of frame ", report.frame, ": stats")));
  switch (result.what_case()) {
    case v1::TileResult::kPixels:
      report.pixels = std::move(*result.mutable_pixels());
      return report;
    case v1::TileResult::kFailure: {
      report.failed = true;
      const absl::Status reason(absl::StatusCode(result.failure().code()),
                                Utf8Prefix(result.failure().message(), kMaxFailureBytes));
      report.failure = reason.ok() ? "a failure without a reason" : reason.ToString();
      return report;
    }
    case v1::TileResult::WHAT_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError(absl::StrCat("tiles: the result of tile ", report.tile, " of frame ",
                                                 report.frame, " has neither pixels nor failure"));
}

}  // namespace shutterline::server
