#include "tests/bench/measure.h"

#include <algorithm>
#include <span>
#include <utility>

#include "common/base/status_macros.h"
#include "tests/bench/stopwatch.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/shading/shading_cache.h"

namespace shutterline::bench {
namespace {

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

/// Tiles lie one below the other, so each is a piece of the stack's memory.
void RenderStack(const engine::TileIntegrator& integrator, const TileSubset& subset, int threads,
                 Image& stack, engine::RenderStats& stats) {
  std::vector<engine::RenderStats> own(static_cast<size_t>(threads));
  ParallelFor(int(subset.tiles.size()), threads, [&](int index, int thread) {
    const TileRect& tile = subset.tiles[size_t(index)];
    const std::span<float> rgba(stack.At(0, index * kTileSize), 4 * size_t(tile.Area()));
    integrator.Render(tile, rgba, own[size_t(thread)]);
  });
  for (const engine::RenderStats& s : own) stats += s;
}

/// A few tiles beside those of the subset, none of which it has: none where it is the whole frame.
TileSubset TilesBeside(const TileSubset& subset, int width, int count) {
  TileSubset beside = subset;
  beside.tiles.clear();
  for (TileRect tile : subset.tiles) {
    if (int(beside.tiles.size()) == count) break;
    tile.x += tile.x + 2 * kTileSize <= width ? kTileSize : -kTileSize;
    const auto is_there = [&](const TileRect& other) { return other.x == tile.x && other.y == tile.y; };
    if (tile.x >= 0 && std::none_of(subset.tiles.begin(), subset.tiles.end(), is_there))
      beside.tiles.push_back(tile);
  }
  return beside;
}

}  // namespace

absl::StatusOr<Measurement> Measure(std::shared_ptr<const engine::Scene> scene, int frame,
                                    const RenderSettings& settings, const TileSubset& subset,
                                    const MeasureOptions& options) {
  Measurement result;
  result.share = subset.Share();
  const Stopwatch pose;
  SL_ASSIGN_OR_RETURN(const auto frame_scene, engine::BuildFrameScene(std::move(scene), frame, settings));
  result.pose_wall = pose.Wall();
  result.pose_cpu = pose.Cpu();

  // Lines have a cache of shadings, as in a worker, and what one run has shaded is not there for the next. A
  // new integrator's scratch memory is filled first: a frame pays for that once, and a subset's times are
  // multiplied.
  const bool has_cache = settings.integrator == IntegratorKind::kLine;
  const TileSubset beside = TilesBeside(subset, settings.width, 4 * options.threads);
  std::unique_ptr<engine::TileIntegrator> integrator;
  std::vector<double> wall, cpu, build_wall, build_cpu;
  for (int run = 0; run < options.most_runs; ++run) {
    if (!integrator || options.new_seeds || has_cache) {
      RenderSettings seeded = settings;
      if (options.new_seeds) seeded.seed = options.first_seed + uint64_t(run);
      integrator.reset();
      const Stopwatch build;
      std::shared_ptr<engine::ShadingCache> cache;
      if (has_cache) {
        SL_ASSIGN_OR_RETURN(cache, engine::ShadingCache::Create(engine::kDefaultShadingCacheBytes));
      }
      SL_ASSIGN_OR_RETURN(integrator, engine::MakeTileIntegrator(frame_scene, frame, seeded, options.threads,
                                                                 std::move(cache)));
      build_wall.push_back(build.Wall());
      build_cpu.push_back(build.Cpu());
      if (has_cache && !beside.tiles.empty()) {
        Image unused = StackedImage(beside);
        engine::RenderStats unused_stats;
        RenderStack(*integrator, beside, options.threads, unused, unused_stats);
      }
    }
    Image stack = StackedImage(subset);
    engine::RenderStats stats;
    const Stopwatch tiles;
    RenderStack(*integrator, subset, options.threads, stack, stats);
    wall.push_back(tiles.Wall());
    cpu.push_back(tiles.Cpu());
    if (run == 0) result.stats = stats;
    if (run == 0 || options.new_seeds) result.pictures.push_back(std::move(stack));
    const double longest = *std::max_element(wall.begin(), wall.end());
    if (longest > 3 || (longest > 1 && run >= 2)) break;
  }
  result.runs = int(wall.size());
  result.build_wall = Median(build_wall);
  result.build_cpu = Median(build_cpu);
  result.tiles_wall = Median(wall);
  result.tiles_cpu = Median(cpu);
  result.tiles_wall_min = *std::min_element(wall.begin(), wall.end());
  result.tiles_wall_max = *std::max_element(wall.begin(), wall.end());
  return result;
}

absl::StatusOr<Image> RenderSubset(std::shared_ptr<const engine::FrameScene> frame_scene, int frame,
                                   const RenderSettings& settings, const TileSubset& subset, int threads) {
  SL_ASSIGN_OR_RETURN(const auto integrator,
                      engine::MakeTileIntegrator(std::move(frame_scene), frame, settings, threads));
  Image stack = StackedImage(subset);
  engine::RenderStats stats;
  RenderStack(*integrator, subset, threads, stack, stats);
  return stack;
}

}  // namespace shutterline::bench
