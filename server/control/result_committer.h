#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include "server/assemble/tile_journal.h"
#include "server/control/events.h"
#include "server/control/farm.h"

namespace shutterline::server {

/// Makes results durable in groups: what arrives within a few milliseconds, or as soon as enough has come,
/// goes to the disk with one flush, is counted, and is acknowledged. One thread; batches are answered in the
/// order in which they came. Thread-safe.
class ResultCommitter {
 public:
  /// Called once a batch, on the committer's thread: an outcome a tile, or why nothing was stored.
  using Done = std::function<void(const absl::Status&, const std::vector<ReportOutcome>&)>;

  ResultCommitter(Farm& farm, TileJournal& journal, absl::Duration interval, int enough_tiles);
  ~ResultCommitter();  ///< Stop.

  /// After Stop, `done` is called at once with UNAVAILABLE.
  void Enqueue(WorkerId worker, std::vector<TileReport> tiles, Done done);
  /// Commits what has come and ends the thread.
  void Stop();

 private:
  struct Batch {
    WorkerId worker = 0;
    std::vector<TileReport> tiles;
    Done done;
  };
  void Work();
  void Commit(std::deque<Batch> batches);

  Farm& farm_;
  TileJournal& journal_;
  const absl::Duration interval_;
  const size_t enough_tiles_;
  absl::Mutex mutex_;
  std::deque<Batch> queue_ ABSL_GUARDED_BY(mutex_);
  size_t queued_tiles_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace shutterline::server
