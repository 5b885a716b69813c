#include "server/coordinator.h"

#include <absl/base/thread_annotations.h>
#include <absl/strings/str_cat.h>
#include <absl/synchronization/mutex.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <thread>
#include <utility>

#include "common/base/build_id.h"
#include "common/base/host_port.h"
#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "proto/convert/protocol.h"
#include "server/api/asset_service.h"
#include "server/api/job_service.h"
#include "server/api/stream_limits.h"
#include "server/api/worker_service.h"
#include "server/assemble/frame_blocks.h"
#include "server/assemble/frame_thumbnails.h"
#include "server/assemble/tile_journal.h"
#include "server/assets/blob_scene_source.h"
#include "server/assets/disk_asset_store.h"
#include "server/assets/metrics_asset_store.h"
#include "server/auth/authorizer.h"
#include "server/auth/server_credentials.h"
#include "server/cameras/frame_cameras.h"
#include "server/control/farm.h"
#include "server/control/result_committer.h"
#include "server/control/work_pool.h"
#include "server/files/file.h"
#include "server/http/http_server.h"
#include "server/jobs/sqlite_job_store.h"
#include "server/logs/job_logs.h"
#include "server/observe/metrics.h"
#include "server/observe/observers.h"
#include "server/observe/throughput.h"
#include "server/observe/timeline.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/scene_names.h"
#include "worker/engine/scene/scene_shelf.h"

namespace shutterline::server {
namespace {

constexpr int kPoolThreads = 4;
constexpr int kSubmitThreads = 2;  ///< Each may hold a whole scene in memory.
constexpr int kFrameThreads = 2;   ///< Each may hold a whole frame's file in memory.
constexpr absl::Duration kTick = absl::Milliseconds(50);

absl::Status CheckScene(const JobSpec& spec, AssetStore& assets, FrameCameras& cameras,
                        engine::SceneShelf* shelf) {
  const BlobSceneSource source(spec.scene, assets);
  SL_ASSIGN_OR_RETURN(const std::shared_ptr<const engine::Scene> scene, engine::ImportGltf(source));
  SL_RETURN_IF_ERROR(engine::ValidateAgainstScene(*scene, spec.render));
  SL_RETURN_IF_ERROR(cameras.Keep(spec, *scene));
  if (shelf != nullptr) shelf->Put(PictureKey(spec.scene, RenderSettings()), scene);
  return absl::OkStatus();
}

/// A scene that cannot be rendered is the request's fault, whatever the importer calls it; troubles of our
/// own disk are not.
absl::Status CheckSubmittedScene(const JobSpec& spec, AssetStore& assets, FrameCameras& cameras,
                                 const Clock& clock, absl::Duration time, engine::SceneShelf* shelf) {
  const absl::Status status = WithinWorkLimit(clock, time, absl::StrCat("load scene ", spec.scene.root_name),
                                              [&] { return CheckScene(spec, assets, cameras, shelf); });
  switch (status.code()) {
    case absl::StatusCode::kOk:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kInternal:
      return status;
    default:
      return absl::InvalidArgumentError(status.message());
  }
}

}  // namespace

class Coordinator::Impl {
 public:
  Impl(const Config& config, const Clock& clock, engine::SceneShelf* shelf)
      : config_(config), clock_(clock), shelf_(shelf) {}
  ~Impl() { Shutdown(absl::ZeroDuration()); }

  absl::Status Start();
  void Shutdown(absl::Duration grace);
  int port() const { return port_; }
  int http_port() const { return http_ == nullptr ? 0 : http_->port(); }
  std::shared_ptr<grpc::Channel> InProcessChannel();

 private:
  absl::Status OpenStores();
  absl::Status StartServer();
  absl::Status StartHttp();
  void TickUntilStopped();

  const Config config_;
  const Clock& clock_;
  engine::SceneShelf* const shelf_;
  const CoordinatorIdentity identity_{kBuildId, convert::kProtocolLow, convert::kProtocolHigh};

  // In the order in which they depend on each other: freed from the last to the first.
  std::unique_ptr<JobLogs> logs_;
  std::unique_ptr<SqliteJobStore> store_;
  std::unique_ptr<DiskAssetStore> assets_;
  std::unique_ptr<MetricsAssetStore> counted_assets_;
  std::unique_ptr<TileJournal> journal_;
  std::unique_ptr<FrameBlocks> blocks_;
  std::unique_ptr<FrameThumbnails> thumbnails_;
  FrameCameras cameras_;
  std::unique_ptr<Metrics> metrics_;
  Timeline timeline_;
  Throughput throughput_{clock_};
  std::unique_ptr<Observers> observers_;
  std::unique_ptr<Farm> farm_;
  std::unique_ptr<WorkPool> frames_pool_, pool_, submit_pool_;
  std::unique_ptr<ResultCommitter> committer_;
  std::shared_ptr<const Authorizer> authorizer_;
  std::unique_ptr<StreamLimits> limits_;
  std::unique_ptr<JobService> job_service_;
  std::unique_ptr<AssetService> asset_service_;
  std::unique_ptr<WorkerService> worker_service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<HttpServer> http_;
  int port_ = 0;

  std::thread ticker_;
  absl::Mutex mutex_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
};

absl::Status Coordinator::Impl::OpenStores() {
  SL_RETURN_IF_ERROR(MakeFolders(config_.data_dir, config_.durability));
  SL_ASSIGN_OR_RETURN(
      store_, SqliteJobStore::Open(absl::StrCat(config_.data_dir, "/jobs.sqlite"), config_.durability));
  SL_RETURN_IF_ERROR(SyncFolder(config_.data_dir, config_.durability));
  SL_ASSIGN_OR_RETURN(logs_, JobLogs::Open(absl::StrCat(config_.data_dir, "/logs"), {}));
  DiskAssetStore::Options asset_options;
  asset_options.max_blob_bytes = config_.max_blob_bytes;
  asset_options.limit_bytes = config_.blob_limit_bytes;
  asset_options.durability = config_.durability;
  SL_ASSIGN_OR_RETURN(assets_,
                      DiskAssetStore::Open(absl::StrCat(config_.data_dir, "/assets"), asset_options, clock_));
  TileJournal::Options journal_options;
  journal_options.durability = config_.durability;
  SL_ASSIGN_OR_RETURN(journal_,
                      TileJournal::Open(absl::StrCat(config_.data_dir, "/journal"), journal_options));
  FrameBlocks::Options block_options;
  block_options.max_block_bytes = config_.frame_block_bytes;
  blocks_ = std::make_unique<FrameBlocks>(block_options);
  thumbnails_ = std::make_unique<FrameThumbnails>(*journal_);
  const std::string frames_folder = absl::StrCat(config_.data_dir, "/frames");
  SL_RETURN_IF_ERROR(MakeFolders(frames_folder, config_.durability));

  frames_pool_ = std::make_unique<WorkPool>(kFrameThreads);
  pool_ = std::make_unique<WorkPool>(kPoolThreads);
  submit_pool_ = std::make_unique<WorkPool>(kSubmitThreads);
  Farm::Parts parts;
  parts.config = config_;
  parts.clock = &clock_;
  parts.store = store_.get();
  parts.assets = assets_.get();
  parts.journal = journal_.get();
  parts.blocks = blocks_.get();
  parts.frames_pool = frames_pool_.get();
  parts.frames_folder = frames_folder;
  SL_ASSIGN_OR_RETURN(parts.epoch, store_->NextEpoch());
  metrics_ = std::make_unique<Metrics>(kBuildId, parts.epoch);
  counted_assets_ = std::make_unique<MetricsAssetStore>(
      *assets_, [this](uint64_t received, uint64_t sent) { metrics_->CountBlobBytes(received, sent); });
  observers_ =
      std::make_unique<Observers>(std::vector<FarmObserver*>{metrics_.get(), &timeline_, &throughput_});
  parts.observer = observers_.get();
  parts.identity = identity_;
  parts.check_scene = [this](const JobSpec& spec, AssetStore& assets) {
    return CheckSubmittedScene(spec, assets, cameras_, clock_, config_.scene_time, shelf_);
  };
  parts.camera = [this](const JobSpec& spec, AssetStore& assets, int frame) {
    // After a restart the camera may have to be imported anew.
    return WithinWorkLimit(clock_, config_.scene_time, absl::StrCat("load scene ", spec.scene.root_name),
                           [&] { return cameras_.At(spec, assets, frame); });
  };
  parts.remove_log = [this](const std::string& job_id) { return logs_->Remove(job_id, config_.durability); };
  parts.matte_names = [](const JobSpec& spec, AssetStore& assets) {
    return engine::ReadMatteNames(BlobSceneSource(spec.scene, assets));
  };
  farm_ = std::make_unique<Farm>(std::move(parts));
  return farm_->Resume();
}

absl::Status Coordinator::Impl::StartServer() {
  committer_ =
      std::make_unique<ResultCommitter>(*farm_, *journal_, config_.commit_interval, config_.commit_tiles);
  SL_ASSIGN_OR_RETURN(authorizer_, Authorizer::Make(config_.security));
  limits_ = std::make_unique<StreamLimits>(config_.streams, clock_);
  job_service_ = std::make_unique<JobService>(JobService::Parts{*farm_, timeline_, *logs_, *thumbnails_,
                                                                config_, identity_, *pool_, *submit_pool_,
                                                                *authorizer_, *limits_});
  asset_service_ = std::make_unique<AssetService>(*counted_assets_, *pool_, *limits_);
  worker_service_ = std::make_unique<WorkerService>(*farm_, *committer_, config_, *limits_);

  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  builder.SetMaxReceiveMessageSize(config_.max_message_bytes);
  grpc::ResourceQuota buffers("coordinator");
  builder.SetResourceQuota(buffers.Resize(size_t(config_.streams.max_buffer_bytes)));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, config_.streams.max_streams_per_connection);
  // Who dials and does not speak, or has nothing more to say, does not keep us.
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_IDLE_MS, 300'000);
  // Pings of workers every 20 s, also between calls, are welcome.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 10'000);
  // A port that another coordinator serves is taken.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  if (!config_.listen.empty()) {
    SL_ASSIGN_OR_RETURN(const auto credentials, MakeServerCredentials(config_.security, authorizer_));
    builder.AddListeningPort(config_.listen, credentials, &port_);
  }
  builder.RegisterService(job_service_.get());
  builder.RegisterService(asset_service_.get());
  builder.RegisterService(worker_service_.get());
  server_ = builder.BuildAndStart();
  if (server_ == nullptr || (!config_.listen.empty() && port_ == 0)) {
    return absl::UnavailableError(absl::StrCat("cannot listen on ", config_.listen));
  }
  return absl::OkStatus();
}

absl::Status Coordinator::Impl::StartHttp() {
  if (config_.http.empty()) return absl::OkStatus();
  HttpServer::Parts parts;
  parts.listen = config_.http;
  parts.names = config_.http_names;
  if (config_.security.authenticates()) {
    // Over HTTP nobody can say who he is.
    parts.may_control = [](const HttpRequestFacts&) {
      return absl::PermissionDeniedError("this coordinator asks callers who they are: use the command line");
    };
  }
  parts.clock = &clock_;
  parts.farm = farm_.get();
  parts.journal = journal_.get();
  parts.metrics = metrics_.get();
  parts.timeline = &timeline_;
  parts.throughput = &throughput_;
  parts.build_id = kBuildId;
  SL_ASSIGN_OR_RETURN(http_, HttpServer::Start(std::move(parts)));
  spdlog::info("dashboard and metrics are served http={} port={}", config_.http, http_->port());
  return absl::OkStatus();
}

absl::Status Coordinator::Impl::Start() {
  SL_RETURN_IF_ERROR(Validate(config_));
  SL_RETURN_IF_ERROR(Annotate(OpenStores(), absl::StrCat("open ", config_.data_dir)));
  SL_RETURN_IF_ERROR(StartServer());
  SL_RETURN_IF_ERROR(StartHttp());
  ticker_ = std::thread([this] { TickUntilStopped(); });
  const ListenSecurity& security = config_.security;
  spdlog::info("coordinator serves listen={} port={} tls={} callers={} data={} epoch={} build={}",
               config_.listen.empty() ? "in-process" : config_.listen, port_, security.encrypts(),
               security.authenticates() ? "named" : "anybody", config_.data_dir, farm_->epoch(), kBuildId);
  if (!config_.listen.empty() && !security.authenticates()) {
    spdlog::warn("callers are not asked who they are, and nothing is encrypted: {}",
                 IsLoopback(HostOf(config_.listen))
                     ? "only this machine can call"
                     : "every machine that reaches this port may do everything");
  }
  return absl::OkStatus();
}

void Coordinator::Impl::TickUntilStopped() {
  while (true) {
    {
      absl::MutexLock lock(&mutex_);
      if (mutex_.AwaitWithTimeout(absl::Condition(&stopping_), kTick)) return;
    }
    farm_->Tick();
    limits_->deadlines.Tick();
  }
}

std::shared_ptr<grpc::Channel> Coordinator::Impl::InProcessChannel() {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  return server_->InProcessChannel(arguments);
}

void Coordinator::Impl::Shutdown(absl::Duration grace) {
  {
    absl::MutexLock lock(&mutex_);
    if (std::exchange(stopping_, true)) return;
  }
  if (ticker_.joinable()) {
    ticker_.join();
    farm_->Tick();  // What is due for the disk.
  }
  if (server_ != nullptr) {
    farm_->Drain();
    // Streams to workers end by themselves when the workers have drained, or else at the deadline.
    server_->Shutdown(std::chrono::system_clock::now() + absl::ToChronoMilliseconds(grace));
    server_->Wait();
  }
  if (http_ != nullptr) http_->Stop();
  if (committer_ != nullptr) committer_->Stop();
  for (WorkPool* pool : {submit_pool_.get(), pool_.get(), frames_pool_.get()}) {
    if (pool != nullptr) pool->Stop();
  }
  if (farm_ != nullptr) spdlog::info("coordinator stopped epoch={}", farm_->epoch());
}

Coordinator::Coordinator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Coordinator::~Coordinator() = default;

absl::StatusOr<std::unique_ptr<Coordinator>> Coordinator::Start(const Config& config, const Clock& clock,
                                                                engine::SceneShelf* shelf) {
  auto impl = std::make_unique<Impl>(config, clock, shelf);
  SL_RETURN_IF_ERROR(impl->Start());
  return std::unique_ptr<Coordinator>(new Coordinator(std::move(impl)));
}

int Coordinator::http_port() const {
  return impl_->http_port();
}
int Coordinator::port() const {
  return impl_->port();
}
std::shared_ptr<grpc::Channel> Coordinator::InProcessChannel() {
  return impl_->InProcessChannel();
}
void Coordinator::Shutdown(absl::Duration grace) {
  impl_->Shutdown(grace);
}

}  // namespace shutterline::server
