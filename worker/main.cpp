// shutterline-worker: wiring alone.

#include <spdlog/spdlog.h>
#include <unistd.h>

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
#include "worker/worker.h"

namespace {

using namespace shutterline;

/// Waits for signals for as long as the process lives: the first lets the worker finish, the second ends
/// the process. SIGTERM and SIGINT must be blocked in all threads.
void WaitForSignals(const sigset_t& signals, worker::Worker& worker) {
  int signal = 0;
  sigwait(&signals, &signal);
  spdlog::info("draining signal={}", signal);
  worker.Drain();
  sigwait(&signals, &signal);
  spdlog::warn("leaving at once signal={}", signal);
  _exit(1);
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
  if (!status.ok()) {
    std::fprintf(stderr, "shutterline-worker: %s\n", std::string(status.message()).c_str());
    return 2;
  }

  // Before any thread is made: threads inherit the mask.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  if (config->memory_bytes > 0) {
    status = worker::LimitMemory(config->memory_bytes);
    if (!status.ok()) {
      std::fprintf(stderr, "shutterline-worker: %s\n", std::string(status.message()).c_str());
      return 1;
    }
  }

  std::shared_ptr<engine::ShadingCache> cache;
  if (config->shading_cache_bytes > 0) {
    auto made = engine::ShadingCache::Create(config->shading_cache_bytes);
    if (!made.ok()) {
      std::fprintf(stderr, "shutterline-worker: %s\n", made.status().ToString().c_str());
      return 1;
    }
    cache = *std::move(made);
  }
  worker::EngineFrameRendererFactory engine(cache);
  const auto channel = worker::DialCoordinator(config->coordinator, config->security);
  if (!channel.ok()) {
    std::fprintf(stderr, "shutterline-worker: %s\n", std::string(channel.status().message()).c_str());
    return 2;
  }
  auto worker = worker::Worker::Start(*channel, config->worker, engine);
  if (!worker.ok()) {
    std::fprintf(stderr, "shutterline-worker: %s\n", worker.status().ToString().c_str());
    return 1;
  }
  std::thread(WaitForSignals, std::cref(signals), std::ref(**worker)).detach();

  const absl::Status end = (*worker)->Wait();
  const worker::WorkerCounts counts = (*worker)->counts();
  spdlog::info("worker left tiles={} failed={} status={}", counts.tiles_rendered, counts.tiles_failed,
               LogValue(end.ToString()));
  std::fflush(nullptr);
  // Without destructors: the thread that waits for signals still uses the worker.
  _exit(end.ok() ? 0 : 1);
}
