#include "worker/engine/stochastic/stochastic_integrator.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "worker/engine/render/stage_timer.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/stochastic/cell.h"
#include "worker/engine/stochastic/cell_film.h"
#include "worker/engine/stochastic/pass_raster.h"
#include "worker/engine/stochastic/pass_shape.h"

namespace shutterline::engine {
namespace {

/// Keys of the cell's pixels in the order of a shape's blocks.
void MakeKeys(const StratifiedPattern& pattern, const TileRect& cell, const Pass& pass,
              PassBuffers& buffers) {
  for (int y = pass.y0; y < pass.y1; ++y) {
    for (int x = pass.x0; x < pass.x1; ++x) {
      const size_t to = PixelIndex(pass.shape, x, y);
      const SampleKeys keys = pattern.Keys(cell.x + x, cell.y + y, pass.first_stratum);
      buffers.key_a[to] = keys.a;
      buffers.key_b[to] = keys.b;
      buffers.key_c[to] = keys.c;
      buffers.key_t[to] = keys.t;
    }
  }
}

}  // namespace

struct StochasticIntegrator::Workspace {
  std::vector<uint32_t> candidates;
  CellTriangles cell;
  PassBuffers buffers;
  CellFilm film;
};

absl::StatusOr<std::unique_ptr<TileIntegrator>> StochasticIntegrator::Create(
    std::shared_ptr<const FrameScene> frame_scene, int frame, const RenderSettings& settings, int threads) {
  SL_ASSIGN_OR_RETURN(Shader shader, Shader::Create(frame_scene, settings, threads));
  SL_RETURN_IF_ERROR(shader.CheckOpaque("integrator stochastic"));
  if (!settings.shutter_curve.empty()) {
    return absl::UnimplementedError("integrator stochastic: it knows no shutter curve but box");
  }
  SL_ASSIGN_OR_RETURN(std::unique_ptr<const Bvh> bvh, Bvh::Build(frame_scene, threads));
  return std::unique_ptr<TileIntegrator>(
      new StochasticIntegrator(std::move(frame_scene), std::move(shader), frame, settings, std::move(bvh)));
}

StochasticIntegrator::StochasticIntegrator(std::shared_ptr<const FrameScene> frame_scene, Shader shader,
                                           int frame, const RenderSettings& settings,
                                           std::unique_ptr<const Bvh> bvh)
    : frame_(std::move(frame_scene)),
      pattern_(settings.seed, frame, settings.spp),
      bvh_(std::move(bvh)),
      shader_(std::move(shader)),
      traits_(shader_.Traits()) {
  SL_CHECK(settings.spp >= 1);
}

StochasticIntegrator::~StochasticIntegrator() = default;

std::unique_ptr<StochasticIntegrator::Workspace> StochasticIntegrator::TakeWorkspace() const {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) return std::make_unique<Workspace>();
  std::unique_ptr<Workspace> workspace = std::move(idle_.back());
  idle_.pop_back();
  return workspace;
}

void StochasticIntegrator::GiveBack(std::unique_ptr<Workspace> workspace) const {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(workspace));
}

void StochasticIntegrator::Render(const TileRect& rect, std::span<float> rgba, RenderStats& stats) const {
  SL_CHECK(int64_t(rgba.size()) == 4 * rect.Area());
  std::unique_ptr<Workspace> workspace = TakeWorkspace();
  const auto floor_cell = [](int v) { return v / kCellSize * kCellSize; };
  for (int y = floor_cell(rect.y); y < rect.y + rect.height; y += kCellSize) {
    for (int x = floor_cell(rect.x); x < rect.x + rect.width; x += kCellSize) {
      const int x0 = std::max(x, rect.x), x1 = std::min(x + kCellSize, rect.x + rect.width);
      const int y0 = std::max(y, rect.y), y1 = std::min(y + kCellSize, rect.y + rect.height);
      RenderCell({x0, y0, x1 - x0, y1 - y0}, rect, rgba, stats, *workspace);
    }
  }
  GiveBack(std::move(workspace));
  ++stats.tiles;
}

void StochasticIntegrator::RenderCell(const TileRect& part, const TileRect& rect, std::span<float> rgba,
                                      RenderStats& stats, Workspace& w) const {
  const TileRect cell{part.x / kCellSize * kCellSize, part.y / kCellSize * kCellSize, kCellSize, kCellSize};
  StageTimer timer;
  w.candidates.clear();
  bvh_->CollectVisible(part, w.candidates);
  timer.Lap(stats.cull_seconds);

  SetUpCell(*frame_, traits_, cell.x, cell.y, w.candidates, w.cell);
  w.film.Reset(shader_, w.cell);
  Pass pass;
  pass.shape = ChoosePassShape(w.cell, pattern_.spp());
  pass.spp = pattern_.spp();
  pass.x0 = part.x - cell.x;
  pass.y0 = part.y - cell.y;
  pass.x1 = pass.x0 + part.width;
  pass.y1 = pass.y0 + part.height;
  stats.candidate_triangles += int64_t(w.candidates.size());
  timer.Lap(stats.setup_seconds);

  // With nothing to see there is nothing to sample.
  for (int first = 0; first < pass.spp && !w.candidates.empty(); first += pass.shape.strata) {
    pass.first_stratum = first;
    if (first % (1 << 16) == 0) MakeKeys(pattern_, cell, pass, w.buffers);
    const PassCounts counts = RasterizePass(w.cell, pass, w.buffers);
    stats.segments += counts.tested;
    stats.spans += counts.hit;
    timer.Lap(stats.resolve_seconds);
    w.film.AddPass(pass, w.buffers);
    timer.Lap(stats.shade_seconds);
  }
  w.film.Write(pass, cell.x, cell.y, rect, rgba, stats);
  stats.instants += part.Area() * pass.spp;
  timer.Lap(stats.shade_seconds);
}

}  // namespace shutterline::engine
