// shutterline-worker: wiring alone.

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <thread>

#include "common/base/ids.h"
#include "common/base/lock_order.h"
#include "common/base/log.h"
#include "common/base/log_format.h"
#include "worker/config.h"
#include "worker/engine/shading/shading_cache.h"
#include "worker/engine_frames/engine_frame_renderer.h"
#include "worker/memory_limit.h"
#include "worker/session/channel.h"
#include "worker/supervise/rendering_table.h"
#include "worker/supervise/supervisor.h"
#include "worker/worker.h"

namespace {

using namespace shutterline;

/// SIGTERM and SIGINT, which must be blocked in all threads.
sigset_t StopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  return signals;
}

[[noreturn]] void LeaveAtOnce(const std::string& why) {
  spdlog::warn("leaving at once {}", why);
  std::fflush(nullptr);
  _exit(1);
}

/// Waits for signals for as long as the process lives: the first lets the worker finish, the second ends the
/// process, unless it is the supervisor who says when.
void WaitForSignals(bool supervised, worker::Worker& worker) {
  const sigset_t signals = StopSignals();
  for (bool first = true; true; first = false) {
    int signal = 0;
    sigwait(&signals, &signal);
    if (!first && !supervised) LeaveAtOnce(absl::StrCat("signal=", signal));
    if (first) spdlog::info("draining signal={}", signal);
    worker.Drain();
  }
}

void WaitForOrders(int orders, worker::Worker& worker) {
  while (worker::NextOrder(orders) == worker::SupervisorOrder::kDrain) {
    spdlog::info("draining");
    worker.Drain();
  }
  LeaveAtOnce("");
}

int Fail(const absl::Status& status, int exit_code) {
  std::fprintf(stderr, "shutterline-worker: %s\n", std::string(status.message()).c_str());
  return exit_code;
}

/// The worker itself; `supervised` is null where nobody watches this process. Returns its exit status, with
/// threads that still run.
int Work(worker::Config config, const worker::Supervised* supervised, worker::RenderingTable* table) {
  // Before any thread is made: threads inherit the mask.
  const sigset_t signals = StopSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  if (config.memory_bytes > 0) {
    const absl::Status limited = worker::LimitMemory(config.memory_bytes);
    if (!limited.ok()) return Fail(limited, 1);
  }
  std::shared_ptr<engine::ShadingCache> cache;
  if (config.shading_cache_bytes > 0) {
    auto made = engine::ShadingCache::Create(config.shading_cache_bytes);
    if (!made.ok()) return Fail(made.status(), 1);
    cache = *std::move(made);
  }
  config.worker.table = table;
  if (supervised != nullptr) {
    config.worker.boot_id = supervised->boot_id;
    config.worker.exits = supervised->exits;
  }
  // For as long as the process lives, as the threads that wait for signals and orders.
  auto* const engine = new worker::EngineFrameRendererFactory(cache, config.worker.scene_time);
  const auto channel = worker::DialCoordinator(config.coordinator, config.security);
  if (!channel.ok()) return Fail(channel.status(), 2);
  auto started = worker::Worker::Start(*channel, config.worker, *engine);
  if (!started.ok()) return Fail(started.status(), 1);
  worker::Worker& worker = *started->release();
  std::thread(WaitForSignals, supervised != nullptr, std::ref(worker)).detach();
  if (supervised != nullptr) std::thread(WaitForOrders, supervised->orders, std::ref(worker)).detach();

  const absl::Status end = worker.Wait();
  const worker::WorkerCounts counts = worker.counts();
  spdlog::info("worker left tiles={} failed={} status={}", counts.tiles_rendered, counts.tiles_failed,
               LogValue(end.ToString()));
  return end.ok() ? 0 : 1;
}

int WorkSupervised(worker::Config config) {
  // All of its processes are one worker to the coordinator.
  if (config.worker.name.empty()) config.worker.name = worker::DefaultWorkerName();
  const auto table =
      worker::RenderingTable::Create(size_t(std::clamp(worker::ThreadsOf(config.worker), 1, 4096)));
  if (!table.ok()) return Fail(table.status(), 1);
  return worker::Supervise({}, **table, [&](const worker::Supervised& supervised) {
    return Work(config, &supervised, table->get());
  });
}

}  // namespace

int main(int argc, char** argv) {
  TrustLockOrder();
  int exit_code = 0;
  auto config = worker::ParseCommandLine(argc, argv, exit_code);
  if (!config) return exit_code;
  if (config->worker.uuid.empty()) config->worker.uuid = MakeUuid();
  absl::Status status = SetUpLog("worker", config->log_level);
  if (status.ok()) status = SetLogFormat(config->log_format, {{"worker", config->worker.uuid}});
  if (!status.ok()) return Fail(status, 2);
  const int result = config->supervise ? WorkSupervised(*config) : Work(*config, nullptr, nullptr);
  std::fflush(nullptr);
  // Without destructors: threads may still use what they would take away.
  _exit(result);
}
