// Micro-benchmarks of the kernels of line visibility, on the triangles of a tile of `chess` and of `trees`.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "tests/bench/or_exit.h"
#include "tests/support/engine_frame.h"
#include "tests/support/line_weights.h"
#include "worker/engine/accel/bvh.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/visibility/envelope.h"
#include "worker/engine/visibility/pair_weights.h"
#include "worker/engine/visibility/segment.h"
#include "worker/engine/visibility/tile_triangles.h"

namespace shutterline::engine {
namespace {

/// A tile in the middle of the frame, set up; made once for each scene.
struct Prepared {
  std::shared_ptr<const FrameScene> frame_scene;
  std::unique_ptr<const Bvh> bvh;
  std::vector<PrimitiveTraits> traits;
  TileRect rect{512, 320, kTileSize, kTileSize};
  std::vector<uint32_t> candidates;
  TileTriangles tile;
};

const Prepared& Prepare(int64_t which) {
  static std::unique_ptr<Prepared> prepared[2];
  auto& p = prepared[size_t(which)];
  if (p) return *p;
  p = std::make_unique<Prepared>();
  p->frame_scene =
      bench::OrExit(BuildFrameScene(bench::OrExit(LoadTestScene(which == 0 ? "chess" : "trees")), 0, {}));
  p->bvh = bench::OrExit(Bvh::Build(p->frame_scene, 1));
  p->traits.resize(p->frame_scene->primitives.size());
  p->bvh->CollectVisible(p->rect, p->candidates);
  SetUpTile(*p->frame_scene, p->traits, LinePattern::Get(PatternKind::kRgls), p->rect, p->candidates,
            p->tile);
  return *p;
}

void Label(benchmark::State& state) {
  state.SetLabel(state.range(0) == 0 ? "chess" : "trees");
}

void CollectTile(benchmark::State& state) {
  const Prepared& p = Prepare(state.range(0));
  std::vector<uint32_t> candidates;
  for (auto _ : state) {
    candidates.clear();
    p.bvh->CollectVisible(p.rect, candidates);
    benchmark::DoNotOptimize(candidates.data());
  }
  state.SetItemsProcessed(state.iterations() * int64_t(candidates.size()));
  Label(state);
}
BENCHMARK(CollectTile)->Arg(0)->Arg(1);

void SetUp(benchmark::State& state) {
  const Prepared& p = Prepare(state.range(0));
  TileTriangles tile;
  for (auto _ : state) {
    SetUpTile(*p.frame_scene, p.traits, LinePattern::Get(PatternKind::kRgls), p.rect, p.candidates, tile);
    benchmark::DoNotOptimize(tile.triangles.data());
  }
  state.SetItemsProcessed(state.iterations() * int64_t(p.candidates.size()));
  Label(state);
}
BENCHMARK(SetUp)->Arg(0)->Arg(1);

/// All triangles of the tile on one line: those that it misses too, which is what a cull saves.
void Segments(benchmark::State& state) {
  const Prepared& p = Prepare(state.range(0));
  const LinePattern& pattern = LinePattern::Get(PatternKind::kRgls);
  const std::vector<TileLine> lines = pattern.LinesIn(p.rect);
  const SegmentLine line = MakeSegmentLine(pattern, lines[lines.size() / 4]);
  LineSegment segment;
  for (auto _ : state) {
    for (uint32_t i = 0; i < p.tile.triangles.size(); ++i) {
      benchmark::DoNotOptimize(
          MakeSegment(p.tile.triangles[i], i, p.tile.far_depth, line, 0.37, &segment, nullptr));
    }
  }
  state.SetItemsProcessed(state.iterations() * int64_t(p.tile.triangles.size()));
  Label(state);
}
BENCHMARK(Segments)->Arg(0)->Arg(1);

void Envelope(benchmark::State& state) {
  const Prepared& p = Prepare(state.range(0));
  const LinePattern& pattern = LinePattern::Get(PatternKind::kRgls);
  const std::vector<TileLine> lines = pattern.LinesIn(p.rect);
  const SegmentLine line = MakeSegmentLine(pattern, lines[lines.size() / 4]);
  std::vector<LineSegment> segments;
  for (uint32_t i = 0; i < p.tile.triangles.size(); ++i) {
    LineSegment segment;
    if (MakeSegment(p.tile.triangles[i], i, p.tile.far_depth, line, 0.37, &segment, nullptr)) {
      segments.push_back(segment);
    }
  }
  EnvelopeMarcher marcher;
  std::vector<VisibleSpan> spans;
  for (auto _ : state) {
    marcher.March(segments, line.begin, line.end, spans);
    benchmark::DoNotOptimize(spans.data());
  }
  state.SetItemsProcessed(state.iterations() * int64_t(segments.size()));
  Label(state);
}
BENCHMARK(Envelope)->Arg(0)->Arg(1);

/// Pairs of a tile: `range` triangles that every pixel sees some of.
void Pairs(benchmark::State& state) {
  PairWeights weights;
  const int64_t pixels = int64_t{kTileSize} * kTileSize, each = state.range(0);
  for (auto _ : state) {
    weights.Reset(pixels, uint64_t{1} << 40);
    for (int64_t i = 0; i < pixels * each; ++i) {
      weights.Add(i % pixels, {.triangle = uint32_t(i * 7 % 64), .weight = 3});
    }
    benchmark::DoNotOptimize(weights.total());
  }
  state.SetItemsProcessed(state.iterations() * pixels * each);
}
BENCHMARK(Pairs)->Arg(2)->Arg(16);

}  // namespace
}  // namespace shutterline::engine

BENCHMARK_MAIN();
