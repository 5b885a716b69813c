#include "worker/session/connection.h"

#include <absl/strings/str_cat.h>
#include <google/protobuf/duration.pb.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "common/base/utf8.h"
#include "proto/convert/job_spec.h"
#include "proto/convert/render_stats.h"
#include "proto/convert/status.h"
#include "worker/loop/credit.h"

namespace shutterline::worker {
namespace {

/// A coordinator that asks for no heartbeats, or for a flood of them, gets sensible ones.
absl::Duration HeartbeatInterval(const v1::Welcome& welcome) {
  return std::clamp(convert::FromProto(welcome.heartbeat_interval()), absl::Milliseconds(10),
                    absl::Minutes(1));
}

}  // namespace

Connection::Connection(v1::Workers::StubInterface& stub, const v1::Welcome& welcome, const Options& options,
                       LeaseBoard& board, ResultBuffer& results, const Clock& clock)
    : stub_(stub),
      welcome_(welcome),
      options_(options),
      heartbeat_interval_(HeartbeatInterval(welcome)),
      board_(board),
      results_(results),
      clock_(clock),
      board_session_(board.session()) {
  results_.SetPace(welcome_.has_gather() ? convert::FromProto(welcome_.gather()) : options_.gather);
}

absl::Status Connection::Run() {
  session_ = stub_.Session(&session_context_);
  push_ = stub_.PushResults(&results_context_);
  results_.Rewind();
  std::thread pulse([this] { Pulse(); });
  std::thread sender([this] { SendResults(); });
  std::thread receiver([this] { ReceiveAcks(); });

  v1::CoordinatorMessage message;
  while (session_->Read(&message)) Handle(message);

  // One stream is over: so is the other, unless we are leaving and its last words are under way.
  {
    absl::MutexLock lock(&mutex_);
    ended_ = true;
    changed_.SignalAll();
    const absl::Duration deadline = clock_.Monotonic() + options_.closing;
    while (leaving_ && !receiver_ended_ && clock_.Monotonic() < deadline) {
      changed_.WaitWithTimeout(&mutex_, deadline - clock_.Monotonic());
    }
  }
  results_.Interrupt();
  Cancel();
  pulse.join();
  sender.join();
  receiver.join();
  const absl::Status session_status = convert::FromGrpc(session_->Finish());
  const absl::Status push_status = convert::FromGrpc(push_->Finish());
  absl::MutexLock lock(&mutex_);
  left_ = leaving_ && results_.Empty();
  if (left_) return absl::OkStatus();
  // Breaking one stream cancels the other: what was first is the reason.
  SL_RETURN_IF_ERROR(ack_status_);
  if (!session_status.ok() && !absl::IsCancelled(session_status)) return session_status;
  if (!push_status.ok() && !absl::IsCancelled(push_status)) return push_status;
  return session_status;
}

void Connection::Wake() {
  absl::MutexLock lock(&mutex_);
  woken_ = true;
  changed_.SignalAll();
}

void Connection::BeginDrain() {
  absl::MutexLock lock(&mutex_);
  draining_ = true;
  woken_ = true;
  results_.SetPace(absl::ZeroDuration());
  changed_.SignalAll();
}

void Connection::Cancel() {
  session_context_.TryCancel();
  results_context_.TryCancel();
}

// --- Session, down ----------------------------------------------------------------------------------

void Connection::Handle(const v1::CoordinatorMessage& message) {
  {
    absl::MutexLock lock(&mutex_);
    heard_ = true;
  }
  switch (message.what_case()) {
    case v1::CoordinatorMessage::kJob:
      return HandleJob(message.job());
    case v1::CoordinatorMessage::kGrant:
      return HandleGrant(message.grant());
    case v1::CoordinatorMessage::kRevoke: {
      const auto& ids = message.revoke().lease_ids();
      for (const v1::RevokedTiles& lease : message.revoke().tiles()) {
        board_.RevokeTiles(lease.lease_id(), {lease.tiles().data(), size_t(lease.tiles().size())});
      }
      board_.Revoke({ids.data(), size_t(ids.size())});
      results_.Hurry();  // What waited for it to be rendered may wait in vain.
      return;
    }
    case v1::CoordinatorMessage::kForgetJob:
      if (const auto job = jobs_.find(message.forget_job().job_id()); job != jobs_.end()) {
        job->second->forgotten = true;
        jobs_.erase(job);
      }
      return;
    case v1::CoordinatorMessage::kAdopted:
      board_.DropSuspended();
      results_.Hurry();  // What is left of a frame may have been among that.
      return;
    case v1::CoordinatorMessage::kDrain:
      spdlog::info("coordinator is about to stop");
      return;
    case v1::CoordinatorMessage::WHAT_NOT_SET:
      // A newer coordinator may say more than we understand.
      return;
  }
}

void Connection::HandleJob(const v1::JobDetails& details) {
  auto job = std::make_shared<WorkerJob>();
  job->id = details.job_id();
  if (auto scene = convert::FromProto(details.scene(), "scene"); scene.ok()) {
    job->scene = *std::move(scene);
  } else {
    job->status.Update(scene.status());
  }
  if (auto settings = convert::FromProto(details.render(), "render"); settings.ok()) {
    job->settings = *std::move(settings);
  } else {
    job->status.Update(settings.status());
  }
  // The picture of the scene under fixed settings: a key of the scene alone.
  job->scene_key = PictureKey(job->scene, RenderSettings());
  jobs_[details.job_id()] = std::move(job);
}

void Connection::HandleGrant(const v1::Grant& grant) {
  if (grant.adopts() != 0) return HandleAdoption(grant);
  const auto job = jobs_.find(grant.job_id());
  {
    // Before the board has the lease: a tile that is rendered in between would take no wish for another
    // along. A wish for one too many, the other way round, is made up for by the next.
    absl::MutexLock lock(&mutex_);
    if (credit_ > 0) --credit_;
  }
  const bool taken = job != jobs_.end() &&
                     board_.Grant(job->second, grant.lease_id(), grant.frame(),
                                  {grant.tiles().data(), size_t(grant.tiles().size())}, grant.send_at_once());
  if (!taken) {
    spdlog::warn("lease returned lease={} job={} frame={} reason=\"{}\"", grant.lease_id(),
                 LogValue(grant.job_id()), grant.frame(),
                 job == jobs_.end() ? "the job is not known" : "the lease is held already");
  }
  absl::MutexLock lock(&mutex_);
  if (job == jobs_.end()) to_return_.push_back(grant.lease_id());
  woken_ = true;
  changed_.SignalAll();
}

void Connection::HandleAdoption(const v1::Grant& grant) {
  if (board_.Adopt(grant.adopts(), grant.lease_id(), {grant.tiles().data(), size_t(grant.tiles().size())})) {
    results_.Hurry();  // As where tiles are revoked.
    return;
  }
  // All of it has been acknowledged meanwhile.
  absl::MutexLock lock(&mutex_);
  to_return_.push_back(grant.lease_id());
  woken_ = true;
  changed_.SignalAll();
}

// --- Session, up ------------------------------------------------------------------------------------

void Connection::Pulse() {
  absl::MutexLock lock(&mutex_);
  v1::WorkerMessage open;
  open.mutable_open()->set_session_id(welcome_.session_id());
  open.mutable_open()->set_epoch(welcome_.epoch());
  for (const LeaseBoard::Held& held : board_.Suspended()) {
    v1::HeldLease& lease = *open.mutable_open()->add_held();
    lease.set_ticket(held.ticket);
    lease.set_job_id(held.job->id);
    lease.set_frame(held.frame);
    lease.mutable_tiles()->Add(held.tiles.begin(), held.tiles.end());
  }
  if (!Write(open)) return;
  absl::Duration next_beat = clock_.Monotonic() + heartbeat_interval_;
  while (!ended_) {
    woken_ = false;
    if (!WriteDueLocked(next_beat)) return;
    if (said_draining_ && board_.Idle() && results_.Empty()) return Leave();
    while (!woken_ && !ended_ && clock_.Monotonic() < next_beat) {
      changed_.WaitWithTimeout(&mutex_, next_beat - clock_.Monotonic());
    }
  }
}

bool Connection::WriteDueLocked(absl::Duration& next_beat) {
  if (draining_ && !said_draining_) {
    v1::WorkerMessage draining;
    draining.mutable_draining();
    said_draining_ = true;
    if (!Write(draining)) return false;
  }
  const bool beats = clock_.Monotonic() >= next_beat;
  if (beats) NoteStarvation();
  if (const size_t leases = AskForLeasesLocked(false); leases > 0) {
    v1::WorkerMessage credit;
    credit.mutable_credit()->set_leases(uint32_t(leases));
    if (!Write(credit)) return false;
  }
  if (!to_return_.empty()) {
    v1::WorkerMessage back;
    back.mutable_return_leases()->mutable_lease_ids()->Add(to_return_.begin(), to_return_.end());
    to_return_.clear();
    if (!Write(back)) return false;
  }
  if (beats) {
    v1::WorkerMessage beat;
    const std::vector<uint64_t> leases = board_.LiveLeases();
    beat.mutable_heartbeat()->mutable_lease_ids()->Add(leases.begin(), leases.end());
    next_beat = clock_.Monotonic() + heartbeat_interval_;
    if (!Write(beat)) return false;
  }
  return true;
}

size_t Connection::AskForLeasesLocked(bool along) {
  if (draining_) return 0;
  const size_t held = board_.UnrenderedLeases() + credit_;
  const auto slots = size_t(options_.slots);
  const size_t leases = LeasesToAskFor(held, slots, extra_, along);
  if (leases == 0) return 0;
  // Results that wait are sent now instead, and the wish with them: one message in place of two.
  const bool may_wait = !along && welcome_.credit_with_results() && heard_ && MayGoWithResults(held, slots);
  if (may_wait && results_.Hurry()) return 0;
  credit_ += leases;
  return leases;
}

/// Where a frame takes so long to be made ready that threads had nothing else to do for a whole interval, so
/// many leases more that the coordinator, which gives a worker no more than 16 a slot of a job of which
/// nothing comes back, comes to other jobs.
void Connection::NoteStarvation() {
  constexpr size_t kStep = 8, kMostExtra = 32;  // A slot.
  const auto slots = size_t(options_.slots);
  const bool starved = board_.Starved();
  extra_ = starved && starved_ ? std::min(extra_ + kStep * slots, kMostExtra * slots) : starved ? extra_ : 0;
  starved_ = starved;
}

bool Connection::Write(const v1::WorkerMessage& message) {
  mutex_.Unlock();
  const bool written = session_->Write(message);
  mutex_.Lock();
  return written;
}

void Connection::Leave() {
  leaving_ = true;
  results_.Interrupt();  // The sender ends its stream.
  mutex_.Unlock();
  session_->WritesDone();
  mutex_.Lock();
  const absl::Duration deadline = clock_.Monotonic() + options_.closing;
  while (!ended_ && clock_.Monotonic() < deadline) {
    changed_.WaitWithTimeout(&mutex_, deadline - clock_.Monotonic());
  }
  if (!ended_) Cancel();
}

// --- Results ----------------------------------------------------------------------------------------

void Connection::SendResults() {
  // Room for what surrounds the pixels; a single tile goes out however small the limit is.
  const auto limit = size_t(std::clamp<uint64_t>(welcome_.max_batch_bytes(), 64 << 10, 4 << 20)) - 1024;
  // The coordinator does not wait long to hear whose stream this is, and the first tile may take long.
  v1::ResultBatch introduction;
  introduction.set_session_id(welcome_.session_id());
  introduction.set_epoch(welcome_.epoch());
  if (!push_->Write(introduction)) return;
  while (true) {
    const ResultBuffer::Batch batch = results_.NextBatch(limit);
    if (batch.results.empty()) break;
    if (!push_->Write(MakeMessage(batch))) return;
  }
  push_->WritesDone();
}

v1::ResultBatch Connection::MakeMessage(const ResultBuffer::Batch& batch) {
  v1::ResultBatch message;
  message.set_session_id(welcome_.session_id());
  message.set_epoch(welcome_.epoch());
  message.set_batch_id(batch.id);
  for (const ResultBuffer::Result& result : batch.results) {
    v1::TileResult& tile = *message.add_tiles();
    tile.set_job_id(result->task.job->id);
    tile.set_frame(result->task.frame);
    tile.set_tile(result->task.tile);
    // A lease of an earlier session is over, and its number may be another lease's by now.
    tile.set_lease_id(result->task.session == board_session_ ? result->task.lease_id : 0);
    if (result->status.ok()) {
      tile.set_pixels(result->pixels);
      *tile.mutable_stats() = convert::ToProto(result->stats);
    } else {
      tile.mutable_failure()->set_code(int32_t(result->status.code()));
      tile.mutable_failure()->set_message(ValidUtf8(result->status.message()));
    }
    *tile.mutable_render_time() = convert::ToProto(result->render_time);
  }
  if (welcome_.credit_with_results()) {
    absl::MutexLock lock(&mutex_);
    if (heard_) message.set_credit(uint32_t(AskForLeasesLocked(true)));
  }
  return message;
}

void Connection::ReceiveAcks() {
  v1::ResultAck ack;
  while (push_->Read(&ack)) {
    if (absl::Status status = HandleAck(ack); !status.ok()) {
      absl::MutexLock lock(&mutex_);
      ack_status_.Update(Annotate(status, "acknowledgement"));
      break;
    }
    absl::MutexLock lock(&mutex_);
    if (draining_) {
      // Only a worker that leaves waits for the last acknowledgement, and its results wait no more.
      woken_ = true;
      changed_.SignalAll();
    } else if (ack.has_gather()) {
      results_.SetPace(convert::FromProto(ack.gather()));
    }
  }
  if (!leaving_) Cancel();
  absl::MutexLock lock(&mutex_);
  receiver_ended_ = true;
  changed_.SignalAll();
}

absl::Status Connection::HandleAck(const v1::ResultAck& ack) {
  SL_ASSIGN_OR_RETURN(const std::vector<ResultBuffer::Result> results,
                      results_.Acknowledge(ack.batch_id(), size_t(ack.outcomes_size())));
  for (size_t i = 0; i < results.size(); ++i) {
    const TileTask& task = results[i]->task;
    board_.Acknowledged(task);
    const v1::ResultAck::Outcome outcome = ack.outcomes(int(i));
    if (outcome == v1::ResultAck::OUTCOME_MISMATCH || outcome == v1::ResultAck::OUTCOME_REFUSED) {
      spdlog::error("tile not taken job={} frame={} tile={} lease={} outcome={}", LogValue(task.job->id),
                    task.frame, task.tile, task.lease_id, v1::ResultAck::Outcome_Name(outcome));
    }
  }
  return absl::OkStatus();
}

}  // namespace shutterline::worker
