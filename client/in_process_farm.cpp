#include "client/in_process_farm.h"

#include <spdlog/spdlog.h>

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

#include "common/base/status_macros.h"
#include "server/config/config.h"
#include "worker/engine/shading/shading_cache.h"
#include "worker/engine_frames/engine_frame_renderer.h"

namespace shutterline::client {
namespace {

absl::StatusOr<std::filesystem::path> MakeTemporaryFolder() {
  std::error_code error;
  const std::filesystem::path parent = std::filesystem::temp_directory_path(error);
  if (error) return absl::ErrnoToStatus(error.value(), "find the folder for temporary files");
  std::string name = (parent / "shutterline-render.XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    return absl::ErrnoToStatus(errno, absl::StrCat("make temporary folder ", name));
  }
  return name;
}

}  // namespace

absl::StatusOr<std::unique_ptr<InProcessFarm>> InProcessFarm::Start(int threads,
                                                                    uint64_t shading_cache_bytes) {
  std::unique_ptr<InProcessFarm> farm(new InProcessFarm);
  SL_ASSIGN_OR_RETURN(farm->folder_, MakeTemporaryFolder());

  server::Config config;
  config.data_dir = (farm->folder_ / "coordinator").string();
  // The folder goes with the process: there is nobody for whom to wait for the disk.
  config.durability = server::Durability::kProcess;
  // And nothing to wait for together: the worker sends its results in groups already.
  config.commit_interval = absl::ZeroDuration();
  auto coordinator = server::Coordinator::Start(config, Clock::System(), &farm->shelf_);
  if (!coordinator.ok()) return Annotate(coordinator.status(), "start the coordinator in this process");
  farm->coordinator_ = *std::move(coordinator);

  worker::WorkerOptions worker_options;
  worker_options.threads = threads;
  worker_options.shelf = &farm->shelf_;
  worker_options.cache_dir = farm->folder_ / "blobs";
  std::shared_ptr<engine::ShadingCache> cache;
  if (shading_cache_bytes > 0) {
    SL_ASSIGN_OR_RETURN(cache, engine::ShadingCache::Create(shading_cache_bytes));
  }
  farm->engine_ = std::make_unique<worker::EngineFrameRendererFactory>(std::move(cache));
  auto worker = worker::Worker::Start(farm->Channel(), worker_options, *farm->engine_);
  if (!worker.ok()) return Annotate(worker.status(), "start the worker in this process");
  farm->worker_ = *std::move(worker);
  return farm;
}

InProcessFarm::~InProcessFarm() {
  worker_.reset();
  coordinator_.reset();
  std::error_code error;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, error);
  if (error) spdlog::warn("temporary folder left folder={} reason={}", folder_.string(), error.message());
}

std::shared_ptr<grpc::Channel> InProcessFarm::Channel() {
  return coordinator_->InProcessChannel();
}

}  // namespace shutterline::client
