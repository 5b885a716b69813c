#include "server/api/results_reactor.h"

#include <utility>

#include "common/base/status_macros.h"
#include "proto/convert/status.h"
#include "server/api/limits.h"
#include "server/api/messages.h"
#include "server/api/wire.h"

namespace shutterline::server {

ResultsReactor::ResultsReactor(Farm& farm, ResultCommitter& committer, StreamLimits& limits)
    : farm_(farm), committer_(committer), limits_(limits) {
  if (const absl::Status taken = slot_.Take(limits_.results); !taken.ok()) {
    Close(taken);
    return;
  }
  first_deadline_ = limits_.deadlines.Add(limits_.config.first_message, [this] {
    Close(absl::DeadlineExceededError("the first batch, which says who sends, did not come in time"));
  });
  absl::MutexLock lock(&mutex_);
  if (!finished_) StartRead(&incoming_);
}

void ResultsReactor::OnDone() {
  limits_.deadlines.Cancel(first_deadline_);
  delete this;
}

absl::Status ResultsReactor::Handle(v1::ResultBatch& batch) {
  if (!worker_) {
    SL_ASSIGN_OR_RETURN(worker_, farm_.FindSession(batch.session_id(), batch.epoch()));
  }
  if (batch.credit() > 0) farm_.AddCredit(*worker_, batch.credit());
  if (batch.tiles().empty()) return absl::OkStatus();  // It has said who sends.
  const uint64_t batch_id = batch.batch_id();
  std::vector<TileReport> reports;
  reports.reserve(size_t(batch.tiles_size()));
  size_t bytes = 0;
  for (v1::TileResult& result : *batch.mutable_tiles()) {
    SL_ASSIGN_OR_RETURN(TileReport report, TakeReport(result));
    bytes += report.pixels.size();
    reports.push_back(std::move(report));
  }
  {
    absl::MutexLock lock(&mutex_);
    ++pending_;
    pending_bytes_ += bytes;
  }
  committer_.Enqueue(
      *worker_, std::move(reports),
      [this, batch_id, bytes](const absl::Status& status, const std::vector<ReportOutcome>& outcomes) {
        Committed(batch_id, bytes, status, outcomes);
      });
  return absl::OkStatus();
}

void ResultsReactor::OnReadDone(bool ok) {
  if (!ok) return Close(absl::OkStatus());
  {
    absl::MutexLock lock(&mutex_);
    if (finished_) return;
    handling_ = true;
  }
  absl::Status handled;
  {
    v1::ResultBatch batch;
    handled = Decode(incoming_, batch);
    incoming_.Clear();
    if (handled.ok()) handled = Handle(batch);
  }
  if (handled.ok()) limits_.deadlines.Cancel(first_deadline_);
  grpc::Status status;
  {
    absl::MutexLock lock(&mutex_);
    handling_ = false;
    if (!handled.ok() && !closing_) closing_ = handled;
    if (!closing_) {
      read_paused_ = pending_bytes_ > kMaxUncommittedBytes;
      if (!read_paused_) StartRead(&incoming_);
      return;
    }
    if (!TakeFinish(status)) return;
  }
  Finish(status);
}

void ResultsReactor::Committed(uint64_t batch_id, size_t bytes, const absl::Status& committed,
                               const std::vector<ReportOutcome>& outcomes) {
  grpc::Status status;
  {
    absl::MutexLock lock(&mutex_);
    --pending_;
    pending_bytes_ -= bytes;
    if (!committed.ok() && (!closing_ || closing_->ok())) closing_ = committed;
    if (!closing_ || closing_->ok()) {
      v1::ResultAck ack;
      ack.set_batch_id(batch_id);
      for (const ReportOutcome outcome : outcomes) ack.add_outcomes(ToMessage(outcome));
      *ack.mutable_gather() = convert::ToProto(farm_.gather());
      outgoing_.push_back(Encode(ack));
      if (!writing_) {
        writing_ = true;
        StartWrite(&outgoing_.front());
      }
    }
    if (read_paused_ && !closing_ && pending_bytes_ <= kMaxUncommittedBytes) {
      read_paused_ = false;
      StartRead(&incoming_);
    }
    if (!TakeFinish(status)) return;
  }
  Finish(status);
}

void ResultsReactor::OnWriteDone(bool ok) {
  grpc::Status status;
  {
    absl::MutexLock lock(&mutex_);
    writing_ = false;
    outgoing_.pop_front();
    if (!ok) {
      outgoing_.clear();
      if (!closing_ || closing_->ok()) closing_ = absl::CancelledError("the worker went away");
    }
    if (!outgoing_.empty()) {
      writing_ = true;
      StartWrite(&outgoing_.front());
      return;
    }
    if (!TakeFinish(status)) return;
  }
  Finish(status);
}

void ResultsReactor::Close(const absl::Status& reason) {
  grpc::Status status;
  {
    absl::MutexLock lock(&mutex_);
    if (!closing_) closing_ = reason;
    if (!TakeFinish(status)) return;
  }
  Finish(status);
}

bool ResultsReactor::TakeFinish(grpc::Status& status) {
  if (finished_ || writing_ || handling_ || pending_ > 0 || !closing_) return false;
  finished_ = true;
  status = convert::ToGrpc(*closing_);
  slot_.Release();
  return true;
}

}  // namespace shutterline::server
