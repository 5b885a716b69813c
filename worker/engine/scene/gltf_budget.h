#pragma once

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <algorithm>
#include <cstdint>

namespace shutterline::engine {

/// A quantity that a file may use up to a limit: vertices, pixels, bytes. Taken before the memory is.
class GltfBudget {
 public:
  GltfBudget(absl::string_view what, uint64_t limit) : what_(what), limit_(limit) {}

  absl::Status Take(uint64_t amount, absl::string_view element) {
    if (amount > limit_ - used_) {
      return absl::ResourceExhaustedError(absl::StrCat(element, ": ", amount, " ", what_, " more than ",
                                                       used_, " exceed the limit of ", limit_));
    }
    used_ += amount;
    return absl::OkStatus();
  }
  void Raise(uint64_t amount) { limit_ = amount > UINT64_MAX - limit_ ? UINT64_MAX : limit_ + amount; }
  /// Up to `most`, which the limit has not passed.
  void RaiseWithin(uint64_t amount, uint64_t most) { limit_ += std::min(amount, most - limit_); }
  uint64_t Left() const { return limit_ - used_; }

 private:
  absl::string_view what_;  ///< A literal.
  uint64_t limit_;
  uint64_t used_ = 0;
};

}  // namespace shutterline::engine
