#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/server_context.h>

#include <cstdint>
#include <string>

#include "server/control/farm.h"
#include "server/control/work_pool.h"
#include "shutterline/v1/jobs.pb.h"

namespace shutterline::server {

/// One Watch call. At any time it is resting (until OnChange or OnCancel), looking for the next change on the
/// pool, or writing one; the step that finds nothing more to do finishes the call.
class WatchReactor final : public grpc::ServerWriteReactor<v1::JobEvent>, private JobWatcher {
 public:
  WatchReactor(Farm& farm, WorkPool& pool, const v1::WatchRequest& request);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  enum class State { kResting, kBusy, kFinished };

  void OnChange() override;
  /// Goes to the pool, to `Look`.
  void LookSoon();
  void Begin();
  void Look();
  void End(const absl::Status& status);

  Farm& farm_;
  WorkPool& pool_;
  const std::string job_id_;
  uint64_t seq_;  ///< Of the last change that was written. Of the busy step alone.
  bool watching_ = false;
  v1::JobEvent event_;

  absl::Mutex mutex_;
  State state_ ABSL_GUARDED_BY(mutex_) = State::kBusy;
  bool changed_ ABSL_GUARDED_BY(mutex_) = false;  ///< While busy.
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace shutterline::server
