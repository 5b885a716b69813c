#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <vector>

#include "common/image/image.h"
#include "common/job/render_settings.h"
#include "tests/bench/tile_subset.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::bench {

/// What one setting costs, and the pictures that came of it.
struct Measurement {
  // Frame-level work, seconds: pose and projection; hierarchies and what else a method builds.
  double pose_wall = 0, pose_cpu = 0;
  double build_wall = 0, build_cpu = 0;
  // All tiles of the subset, seconds: medians of the runs, and their spread.
  double tiles_wall = 0, tiles_cpu = 0;
  double tiles_wall_min = 0, tiles_wall_max = 0;
  int runs = 0;
  double share = 1;           ///< Of the frame's tiles that were measured.
  engine::RenderStats stats;  ///< Of one run.
  /// Stacks of tiles: one for each run of a method that draws random numbers (other seeds), else one.
  std::vector<Image> pictures;

  /// A whole frame from scene in memory to frame in memory, estimated.
  double FrameWall() const { return pose_wall + build_wall + tiles_wall / share; }
  double FrameCpu() const { return pose_cpu + build_cpu + tiles_cpu / share; }
};

struct MeasureOptions {
  int threads = 1;
  int most_runs = 5;
  bool new_seeds = false;  ///< Every run has a seed of its own: first_seed, first_seed + 1, ...
  uint64_t first_seed = 1001;
};

/// Renders the subset's tiles `most_runs` times; three times where that takes more than a second, once
/// where it takes more than three.
absl::StatusOr<Measurement> Measure(std::shared_ptr<const engine::Scene> scene, int frame,
                                    const RenderSettings& settings, const TileSubset& subset,
                                    const MeasureOptions& options);

/// The tiles' picture alone, of a frame that is already posed.
absl::StatusOr<Image> RenderSubset(std::shared_ptr<const engine::FrameScene> frame_scene, int frame,
                                   const RenderSettings& settings, const TileSubset& subset, int threads);

}  // namespace shutterline::bench
