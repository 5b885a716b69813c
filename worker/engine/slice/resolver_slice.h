#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "common/job/render_settings.h"
#include "worker/engine/sampling/shutter_curve.h"
#include "worker/engine/slice/class_resolver.h"
#include "worker/engine/slice/effort_chooser.h"
#include "worker/engine/slice/line_class.h"
#include "worker/engine/slice/tile_colors.h"
#include "worker/engine/slice/tile_mesh.h"
#include "worker/engine/slice/tile_strata.h"
#include "worker/engine/visibility/resolver.h"

namespace shutterline::engine {

/// Exact along a line, stratified in time: at an instant a moving triangle is a static one, and on a
/// line it is one segment whose depth is exactly linear. So each line is resolved exactly at as many
/// stratified instants as its motion asks for. Departs from [gribel2011, section 5], which approximates
/// what a triangle covers over time by patch triangles and sorts these; see docs/math/line_samples.md.
///
/// Vectors run over lines that share their instants, so triangles are placed once for all of them. What
/// stands still is resolved once per line: only the static pieces that are visible among the static ones take
/// part at the instants, and where nothing moves there is a single instant.
class ResolverSlice final : public Resolver {
 public:
  explicit ResolverSlice(const RenderSettings& settings);

  void Resolve(const TileInput& tile, PairWeights& weights, ColorFilm* flat,
               RenderStats& stats) const override;

 private:
  /// What a tile needs of memory; kept from tile to tile.
  struct Workspace {
    TileMesh mesh;
    TileStrata strata;
    TileColors colors;
    TileLines lines;
    EffortChooser::Workspace effort;
    ClassResolver class_resolver;
    std::vector<double> instants;
  };
  std::unique_ptr<Workspace> TakeWorkspace() const;

  const LinePattern& pattern_;  // Where something moves.
  ShutterCurve shutter_;
  EffortChooser effort_chooser_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<Workspace>> free_workspaces_;  // Guarded by mutex_.
};

}  // namespace shutterline::engine
