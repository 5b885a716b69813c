#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "worker/supervise/worker_exit.h"

namespace shutterline::worker {

/// What each thread of a worker is at, in memory that a process shares with those that it forks: a supervisor
/// reads there what its worker died at. A thread writes its own line alone; lines are read when nobody writes
/// any more.
class RenderingTable {
 public:
  /// RESOURCE_EXHAUSTED where there is no memory.
  static absl::StatusOr<std::unique_ptr<RenderingTable>> Create(size_t threads);
  ~RenderingTable();
  RenderingTable(const RenderingTable&) = delete;
  RenderingTable& operator=(const RenderingTable&) = delete;

  /// `thread` counts from 0; those that the table has no line for are left out.
  void Begin(size_t thread, absl::string_view job_id, int frame, uint32_t tile);
  void End(size_t thread);

  /// What is at hand, each once, and an empty table.
  std::vector<TileAtHand> Take();

 private:
  struct Line;
  RenderingTable(Line* lines, size_t threads) : lines_(lines), threads_(threads) {}

  Line* const lines_;
  const size_t threads_;
};

}  // namespace shutterline::worker
