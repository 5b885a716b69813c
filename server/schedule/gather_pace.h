#pragma once

#include <absl/time/time.h>

#include <cstdint>

namespace shutterline::server {

struct GatherPaceOptions {
  /// Messages with results that a coordinator takes without effort, each with its acknowledgement.
  double messages_per_second = 2000;
  absl::Duration least = absl::Milliseconds(5), most = absl::Milliseconds(500);
};

/// How long workers are to gather results before they send them, by how many come: as little as there is no
/// need for more, so that people see tiles as they come.
///
/// Of N workers that bring T results a second all together, one that sends what has come within g after a
/// first result sends 1 + g T/N results in a message: those are T / (1 + g T/N) messages a second. They are M
/// for g = N (1/M - 1/T). T does not depend on g, so nothing swings. Not thread-safe.
class GatherPace {
 public:
  explicit GatherPace(const GatherPaceOptions& options)
      : options_(options), gather_(options.least), longest_(options.least) {}

  /// So many results have come.
  void Count(int64_t results) { results_ += results; }
  /// To be called some times a second, with the number of workers that are connected.
  void Tick(absl::Duration now, int64_t workers);

  absl::Duration gather() const { return gather_; }
  /// Workers may gather for so long: the longest that was said to them lately. Who has nothing to send does
  /// not hear of a change.
  absl::Duration longest() const { return longest_; }

 private:
  const GatherPaceOptions options_;
  absl::Duration gather_, longest_;
  absl::Duration longest_said_ = -absl::InfiniteDuration();
  absl::Duration began_ = -absl::InfiniteDuration();  ///< When the present count did.
  int64_t results_ = 0;
  double rate_ = 0;  ///< Results a second, a mean over some seconds.
};

}  // namespace shutterline::server
