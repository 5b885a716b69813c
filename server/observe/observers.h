#pragma once

#include <utility>
#include <vector>

#include "server/control/observer.h"

namespace shutterline::server {

/// Tells several observers, which outlive it, in their order.
class Observers final : public FarmObserver {
 public:
  explicit Observers(std::vector<FarmObserver*> all) : all_(std::move(all)) {}

  void OnGranted(const Granted& seen) override {
    for (FarmObserver* one : all_) one->OnGranted(seen);
  }
  void OnLeasesEnded(LeaseEnd end, int64_t leases) override {
    for (FarmObserver* one : all_) one->OnLeasesEnded(end, leases);
  }
  void OnTile(TileOutcome outcome) override {
    for (FarmObserver* one : all_) one->OnTile(outcome);
  }
  void OnTileStored(const TileStored& seen) override {
    for (FarmObserver* one : all_) one->OnTileStored(seen);
  }
  void OnCommitted(const Committed& seen) override {
    for (FarmObserver* one : all_) one->OnCommitted(seen);
  }
  void OnFrameWritten(const FrameWritten& seen) override {
    for (FarmObserver* one : all_) one->OnFrameWritten(seen);
  }
  void OnJobAccepted(absl::string_view job_id) override {
    for (FarmObserver* one : all_) one->OnJobAccepted(job_id);
  }
  void OnJobRemoved(absl::string_view job_id) override {
    for (FarmObserver* one : all_) one->OnJobRemoved(job_id);
  }
  void OnJobEnded(absl::string_view job_id, JobState state) override {
    for (FarmObserver* one : all_) one->OnJobEnded(job_id, state);
  }

 private:
  const std::vector<FarmObserver*> all_;
};

}  // namespace shutterline::server
