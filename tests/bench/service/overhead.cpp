// What the service costs over the bare engine: the same frame by `shutterline render` with one thread, and by
// a process that has the engine alone, turn by turn.
#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "common/image/exr.h"
#include "common/image/image.h"
#include "common/job/tile.h"
#include "tests/bench/service/service_bench.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine_frames/engine_frame_renderer.h"

namespace shutterline::bench {
namespace {

struct Spent {
  absl::Duration wall, cpu;
};

absl::Duration CpuOfChildren() {
  rusage usage{};
  ::getrusage(RUSAGE_CHILDREN, &usage);
  return absl::DurationFromTimeval(usage.ru_utime) + absl::DurationFromTimeval(usage.ru_stime);
}

template <typename Work>
Spent Measure(Work work) {
  const absl::Duration cpu = CpuOfChildren();
  const absl::Time start = absl::Now();
  work();
  return {absl::Now() - start, CpuOfChildren() - cpu};
}

absl::Status RenderBare(const std::string& scene_file, int width, int height, const std::string& output) {
  const auto source = engine::DirectoryAssetSource::Open(scene_file);
  if (!source.ok()) return source.status();
  auto cache = engine::ShadingCache::Create(engine::kDefaultShadingCacheBytes);
  if (!cache.ok()) return cache.status();
  worker::EngineFrameRendererFactory factory(*std::move(cache));
  const auto scene = factory.Import(**source);
  if (!scene.ok()) return scene.status();
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  const auto frame = factory.MakeFrame(*scene, 3, settings, 1);
  if (!frame.ok()) return frame.status();
  Image image(width, height, {"R", "G", "B", "A"});
  const TileGrid grid{width, height};
  std::vector<float> pixels(size_t(kTileSize) * kTileSize * 4);
  for (int tile = 0; tile < grid.Count(); ++tile) {
    const TileRect rect = grid.Rect(tile);
    RenderStats stats;
    const absl::Status status = (*frame)->Render(rect, {pixels.data(), size_t(rect.Area()) * 4}, stats);
    if (!status.ok()) return status;
    for (int y = 0; y < rect.height; ++y) {
      std::copy_n(&pixels[size_t(y * rect.width) * 4], size_t(rect.width) * 4, image.At(rect.x, rect.y + y));
    }
  }
  return WriteExr(output, image, OutputSettings(), {});
}

/// Runs it in a process of its own: one that has rendered before would find its memory in place.
bool RenderBareApart(const std::string& scene_file, int width, int height, const std::string& output) {
  const pid_t child = ::fork();
  if (child < 0) return false;
  if (child == 0) {
    SetExrThreads(
        int(std::thread::hardware_concurrency()));  // Its picture is compressed at the end, all at once.
    const absl::Status status = RenderBare(scene_file, width, height, output);
    if (!status.ok()) std::fprintf(stderr, "overhead: %s\n", std::string(status.message()).c_str());
    ::_exit(status.ok() ? 0 : 1);
  }
  int ended = -1;
  return ::waitpid(child, &ended, 0) == child && ended == 0;
}

}  // namespace

bool MeasureOverhead(const ServiceOptions& options) {
  Farm farm;
  const std::string scene = farm.Scene(options.scene);
  int width = 0, height = 0;
  if (std::sscanf(options.size.c_str(), "%dx%d", &width, &height) != 2) return false;
  const std::string bare_file = (farm.folder() / "bare.exr").string();
  const std::string service_file = (farm.folder() / "service.exr").string();
  absl::Duration bare_wall = absl::InfiniteDuration(), service_wall = bare_wall, bare_cpu = bare_wall,
                 service_cpu = bare_wall;
  for (int i = 0; i < options.repeats; ++i) {
    bool bare_done = false;
    const Spent bare = Measure([&] { bare_done = RenderBareApart(scene, width, height, bare_file); });
    int exit = -1;
    const Spent service = Measure([&] {
      exit = farm.Client({"render", scene, "--threads", "1", "--frame", "3", "--size", options.size, "-o",
                          service_file})
                 .status;
    });
    if (!bare_done || exit != 0) {
      std::fprintf(stderr, "overhead: the engine %s, exit %d of the service\n",
                   bare_done ? "did well" : "failed", exit);
      return false;
    }
    bare_wall = std::min(bare_wall, bare.wall);
    bare_cpu = std::min(bare_cpu, bare.cpu);
    service_wall = std::min(service_wall, service.wall);
    service_cpu = std::min(service_cpu, service.cpu);
  }
  const bool same = PixelBits(bare_file) == PixelBits(service_file);
  std::printf(
      "overhead   scene=%s size=%s bare_wall_s=%.3f service_wall_s=%.3f wall_overhead=%.2f%% bare_cpu_s=%.3f "
      "service_cpu_s=%.3f cpu_overhead=%.2f%% pixels=%s\n",
      options.scene.c_str(), options.size.c_str(), absl::ToDoubleSeconds(bare_wall),
      absl::ToDoubleSeconds(service_wall), 100 * (absl::FDivDuration(service_wall, bare_wall) - 1),
      absl::ToDoubleSeconds(bare_cpu), absl::ToDoubleSeconds(service_cpu),
      100 * (absl::FDivDuration(service_cpu, bare_cpu) - 1), same ? "equal" : "DIFFERENT");
  return same;
}

}  // namespace shutterline::bench
