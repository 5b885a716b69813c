#pragma once

#include <absl/time/time.h>

#include <functional>
#include <string>
#include <vector>

#include "worker/supervise/rendering_table.h"
#include "worker/supervise/worker_exit.h"

namespace shutterline::worker {

/// What a supervised process is told at its start.
struct Supervised {
  std::string boot_id;
  std::vector<WorkerExit> exits;  ///< Of those before it, the latest last.
  int orders = -1;                ///< For NextOrder.
};

/// What a supervisor tells its worker over `Supervised::orders`.
enum class SupervisorOrder { kDrain, kLeave };

/// Waits for the next order. A supervisor that is gone is an order to leave.
SupervisorOrder NextOrder(int orders);

struct SupervisorOptions {
  absl::Duration backoff_initial = absl::Milliseconds(100);  ///< Before the worker is started again.
  absl::Duration backoff_max = absl::Seconds(10);            ///< It doubles up to here.
  absl::Duration healthy_after =
      absl::Minutes(1);  ///< A worker that lived so long begins with the least again.
};

/// Runs `work` in a process of its own until that ends by itself, and returns its exit status. A process that
/// a signal ends is started again, after a while, and told how its predecessors ended: the signal, the end of
/// what they wrote to standard error (which goes on to ours), and what `table` says they were at.
///
/// SIGTERM and SIGINT: the first is an order to drain, the second one to leave. Between two processes either
/// ends us, with status 0. A process that a signal ends after an order is not started again, and we end by
/// that signal. The process dies with us, and finds both signals blocked: sent to all processes of a group,
/// they reach the worker twice, and must not count twice.
///
/// To be called before threads are made, once; leaves signals changed. It returns in the caller's process
/// alone.
int Supervise(const SupervisorOptions& options, RenderingTable& table,
              const std::function<int(const Supervised&)>& work);

}  // namespace shutterline::worker
