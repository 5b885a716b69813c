#include "worker/worker.h"

#include <absl/strings/str_cat.h>
#include <grpcpp/grpcpp.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <random>
#include <thread>
#include <utility>

#include "common/base/build_id.h"
#include "common/base/ids.h"
#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "worker/assets/asset_cache.h"
#include "worker/assets/blob_asset_source.h"
#include "worker/cpu_isa.h"
#include "worker/frames/frame_cache.h"
#include "worker/loop/lease_board.h"
#include "worker/loop/render_loop.h"
#include "worker/loop/result_buffer.h"
#include "worker/session/blob_client.h"
#include "worker/session/coordinator_session.h"

namespace shutterline::worker {
namespace {

/// More threads than any machine has are a slip of the keyboard.
constexpr int kMaxThreads = 4096;

SessionOptions MakeSessionOptions(const WorkerOptions& options) {
  SessionOptions session;
  session.identity = {.uuid = options.uuid.empty() ? MakeUuid() : options.uuid,
                      .boot_id = options.boot_id.empty() ? MakeUuid() : options.boot_id,
                      .build_id = options.build_id.empty() ? std::string(kBuildId) : options.build_id,
                      .isa = DetectIsa(),
                      .name = options.name.empty() ? DefaultWorkerName() : options.name,
                      .exits = options.exits};
  session.slots = options.threads;
  session.backoff.initial = options.backoff_initial;
  session.backoff.max = options.backoff_max;
  session.seed = std::random_device()();
  session.drain_patience = options.drain_patience;
  return session;
}

}  // namespace

std::string DefaultWorkerName() {
  char host[256] = "";
  if (gethostname(host, sizeof host - 1) != 0) host[0] = '\0';
  return absl::StrCat(host[0] == '\0' ? "worker" : host, ":", getpid());
}

int ThreadsOf(const WorkerOptions& options) {
  return options.threads != 0 ? options.threads : int(std::max(1u, std::thread::hardware_concurrency()));
}

struct Worker::Impl {
  Impl(std::shared_ptr<grpc::Channel> channel, const WorkerOptions& options, FrameRendererFactory& factory,
       std::unique_ptr<AssetCache> asset_cache, const Clock& clock)
      : threads(options.threads),
        assets(std::move(asset_cache)),
        results(options.max_result_bytes),
        frames(factory,
               {.max_scenes = options.max_scenes,
                .max_frames = options.max_frames,
                .build_threads = options.threads,
                .retry_late = options.scene_time,
                .shelf = options.shelf},
               clock),
        session_options(MakeSessionOptions(options)),
        blobs(channel, {.backoff = session_options.backoff}, clock),
        session(channel, session_options, board, results, clock),
        loop(
            options.threads, board, results, frames,
            [this](const SceneManifest& scene) -> absl::StatusOr<std::unique_ptr<engine::AssetSource>> {
              return BlobAssetSource::Make(scene, *assets, blobs);
            },
            clock, options.table) {}

  // Destroyed from the bottom up: first nobody renders, then nobody talks.
  const int threads;
  const std::unique_ptr<AssetCache> assets;
  LeaseBoard board;
  ResultBuffer results;
  FrameCache frames;
  const SessionOptions session_options;
  BlobClient blobs;
  CoordinatorSession session;
  RenderLoop loop;
};

absl::StatusOr<std::unique_ptr<Worker>> Worker::Start(std::shared_ptr<grpc::Channel> channel,
                                                      const WorkerOptions& given,
                                                      FrameRendererFactory& factory, const Clock& clock) {
  WorkerOptions options = given;
  options.threads = ThreadsOf(options);
  if (options.threads < 0 || options.threads > kMaxThreads) {
    return absl::InvalidArgumentError(
        absl::StrCat("worker: threads is ", options.threads, ", but must be 0 to ", kMaxThreads));
  }
  if (options.max_scenes < 1 || options.max_frames < 1 || options.max_result_bytes < 1) {
    return absl::InvalidArgumentError(
        "worker: max_scenes, max_frames and max_result_bytes must be at least 1");
  }
  SL_ASSIGN_OR_RETURN(auto assets,
                      AssetCache::Open({.folder = options.cache_dir, .max_bytes = options.cache_bytes}));
  auto impl = std::make_unique<Impl>(std::move(channel), options, factory, std::move(assets), clock);
  const WorkerIdentity& who = impl->session_options.identity;
  spdlog::info("worker started name={} threads={} isa={} build={}", LogValue(who.name), options.threads,
               who.isa, who.build_id);
  impl->session.Start();
  return std::unique_ptr<Worker>(new Worker(std::move(impl)));
}

Worker::Worker(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Worker::~Worker() {
  Stop();
}

void Worker::Drain() {
  impl_->session.Drain();
}

void Worker::Stop() {
  impl_->blobs.Cancel();
  impl_->session.Stop();
}

absl::Status Worker::Wait() {
  return impl_->session.Wait();
}

WorkerCounts Worker::counts() const {
  return {.tiles_rendered = impl_->loop.tiles_rendered(),
          .tiles_failed = impl_->loop.tiles_failed(),
          .registrations = impl_->session.registrations()};
}

int Worker::threads() const {
  return impl_->threads;
}

}  // namespace shutterline::worker
