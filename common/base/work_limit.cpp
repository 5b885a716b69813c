#include "common/base/work_limit.h"

namespace shutterline {
namespace {

thread_local const WorkLimit* current_limit = nullptr;

}  // namespace

const WorkLimit* WorkLimit::Current() {
  return current_limit;
}

void WorkLimit::Check() const {
  if (time_ == absl::InfiniteDuration()) return;
  const absl::Duration paused = absl::Nanoseconds(paused_ns_.load(std::memory_order_relaxed));
  if (clock_.Monotonic() - start_ - paused > time_) throw Exceeded{time_};
}

WorkLimitScope::WorkLimitScope(const WorkLimit* limit) : outer_(current_limit) {
  current_limit = limit;
}

WorkLimitScope::~WorkLimitScope() {
  current_limit = outer_;
}

WorkPause::WorkPause() : limit_(current_limit) {
  if (limit_ != nullptr) start_ = limit_->clock_.Monotonic();
}

WorkPause::~WorkPause() {
  if (limit_ == nullptr) return;
  const absl::Duration paused = limit_->clock_.Monotonic() - start_;
  limit_->paused_ns_.fetch_add(absl::ToInt64Nanoseconds(paused), std::memory_order_relaxed);
}

absl::Status TookTooLong(absl::string_view doing, const WorkLimit::Exceeded& exceeded) {
  return absl::DeadlineExceededError(absl::StrCat(doing, ": it took longer than the ",
                                                  absl::FormatDuration(exceeded.time), " that are allowed"));
}

}  // namespace shutterline
