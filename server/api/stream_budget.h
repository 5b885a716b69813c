#pragma once

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <atomic>
#include <utility>

namespace shutterline::server {

/// How many streams of a kind may be open at a time, over all connections. Thread-safe.
class StreamBudget {
 public:
  /// `kind` names the streams in refusals and lives for ever: "Watch".
  StreamBudget(const char* kind, int limit) : kind_(kind), limit_(limit) {}

  /// The right to one stream, from a Take that was OK until Release. To be released before the stream is
  /// finished: a client that has heard of the end may open the next one at once.
  class Slot {
   public:
    Slot() = default;
    ~Slot() { Release(); }
    Slot(const Slot&) = delete;
    Slot& operator=(const Slot&) = delete;

    /// RESOURCE_EXHAUSTED where all are taken. To be called once.
    absl::Status Take(StreamBudget& budget) {
      if (budget.open_.fetch_add(1) >= budget.limit_) {
        budget.open_.fetch_sub(1);
        return absl::ResourceExhaustedError(
            absl::StrCat(budget.limit_, " ", budget.kind_, " streams are open, and more are not served"));
      }
      budget_ = &budget;
      return absl::OkStatus();
    }
    void Release() {
      if (budget_ != nullptr) std::exchange(budget_, nullptr)->open_.fetch_sub(1);
    }

   private:
    StreamBudget* budget_ = nullptr;
  };

  int open() const { return open_.load(); }

 private:
  const char* const kind_;
  const int limit_;
  std::atomic<int> open_ = 0;
};

}  // namespace shutterline::server
