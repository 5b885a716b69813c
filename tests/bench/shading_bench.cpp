// Micro-benchmarks of shading: pixels of tiles of the textured `chess`, in order, as a frame visits them, and
// shuffled, so that little is in a cache.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <vector>

#include "common/job/tile.h"
#include "tests/bench/or_exit.h"
#include "tests/scenes/scene_generators.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"
#include "worker/engine/shading/footprint.h"
#include "worker/engine/shading/shade.h"

namespace shutterline::engine {
namespace {

constexpr double kMidShutter = 0.5;
/// One tile in so many is looked at.
constexpr size_t kTiles = 11;

struct SeenPoint {
  double depth = 0;
  uint32_t triangle = 0;
  Barycentric at;
};

/// Puts a triangle into a depth buffer of the pixels' corners.
void Draw(const FrameScene& frame, uint32_t triangle, int columns, int rows, std::vector<SeenPoint>& points) {
  const FrameTriangle& corners = frame.triangles[triangle];
  RasterPoint p[3];
  double low_x = 1e9, high_x = -1e9, low_y = 1e9, high_y = -1e9;
  for (int k = 0; k < 3; ++k) {
    p[k] = frame.VertexAt(frame.primitives[corners.primitive], corners.vertices[size_t(k)], kMidShutter);
    if (!(p[k].w > 0) || p[k].z > p[k].w) return;
    low_x = std::min(low_x, p[k].x / p[k].w);
    high_x = std::max(high_x, p[k].x / p[k].w);
    low_y = std::min(low_y, p[k].y / p[k].w);
    high_y = std::max(high_y, p[k].y / p[k].w);
  }
  const auto first = [](double pixel) { return std::max(int(std::ceil(pixel)), 0); };
  const auto last = [](double pixel, int count) { return std::min(int(std::floor(pixel)), count - 1); };
  if (high_x < 0 || high_y < 0) return;
  for (int row = first(low_y); row <= last(high_y, rows); ++row) {
    for (int column = first(low_x); column <= last(high_x, columns); ++column) {
      // Homogeneous edge functions are proportional to the barycentric coordinates in space.
      const double x = column, y = row;
      double edge[3];
      for (int k = 0; k < 3; ++k) {
        const RasterPoint &a = p[(k + 1) % 3], &b = p[(k + 2) % 3];
        edge[k] = x * (a.y * b.w - a.w * b.y) + y * (a.w * b.x - a.x * b.w) + (a.x * b.y - a.y * b.x);
      }
      const bool inside =
          (edge[0] >= 0 && edge[1] >= 0 && edge[2] >= 0) || (edge[0] <= 0 && edge[1] <= 0 && edge[2] <= 0);
      const double sum = edge[0] + edge[1] + edge[2];
      if (!inside || sum == 0) continue;
      const Barycentric at{edge[1] / sum, edge[2] / sum};
      const RasterPoint seen = p[0] + (at.b1 * (p[1] - p[0]) + at.b2 * (p[2] - p[0]));
      SeenPoint& point = points[size_t(row) * size_t(columns) + size_t(column)];
      if (seen.z / seen.w > point.depth) point = {seen.z / seen.w, triangle, at};
    }
  }
}

struct PreparedShading {
  std::unique_ptr<const Shader> shader;
  std::vector<SeenPoint> points;
  std::vector<Footprint> footprints;
};

const PreparedShading& PrepareShading(int64_t shuffled) {
  static std::unique_ptr<const PreparedShading> prepared[2];
  auto& slot = prepared[size_t(shuffled)];
  if (slot) return *slot;
  slot = std::make_unique<const PreparedShading>([&] {
    RenderSettings settings;
    scenes::SceneOptions options;
    options.textured = true;
    const auto glb = bench::OrExit(scenes::GenerateGlb("chess", options));
    const auto scene = bench::OrExit(ImportGltf(MemoryAssetSource("chess.glb", {{"chess.glb", glb}})));
    const auto frame = bench::OrExit(BuildFrameScene(scene, 0, settings));
    PreparedShading p;
    p.shader = std::make_unique<Shader>(bench::OrExit(Shader::Create(frame, settings)));
    const int columns = frame->view.width, rows = frame->view.height;
    std::vector<SeenPoint> picture(size_t(columns) * size_t(rows));
    for (uint32_t i = 0; i < frame->triangles.size(); ++i) Draw(*frame, i, columns, rows, picture);
    size_t tile = 0;
    for (int top = 0; top + kTileSize <= rows; top += kTileSize) {
      for (int left = 0; left + kTileSize <= columns; left += kTileSize) {
        if (tile++ % kTiles != 0) continue;
        for (int y = top; y < top + kTileSize; ++y) {
          for (int x = left; x < left + kTileSize; ++x) {
            const SeenPoint& point = picture[size_t(y) * size_t(columns) + size_t(x)];
            if (point.depth > 0) p.points.push_back(point);
          }
        }
      }
    }
    if (shuffled) std::shuffle(p.points.begin(), p.points.end(), std::mt19937(1));
    for (const SeenPoint& point : p.points) {
      p.footprints.push_back(PixelFootprintAt(*frame, point.triangle, point.at, kMidShutter));
    }
    return p;
  }());
  return *slot;
}

/// Calls `shade(i)` for every point, over and over; times are those of one point.
template <typename Shade>
void ForPoints(benchmark::State& state, const Shade& shade) {
  const size_t count = PrepareShading(state.range(0)).points.size();
  size_t i = 0;
  for (auto _ : state) {
    shade(i);
    if (++i == count) i = 0;
  }
  state.SetLabel(state.range(0) == 0 ? "in order" : "shuffled");
}

void ShadePoint(benchmark::State& state) {
  const PreparedShading& p = PrepareShading(state.range(0));
  ForPoints(state, [&](size_t i) {
    benchmark::DoNotOptimize(p.shader->ShadeFully(p.points[i].triangle, p.points[i].at, p.footprints[i]));
  });
}
BENCHMARK(ShadePoint)->Arg(0)->Arg(1);

/// All of it but light.
void SurfaceOfPoint(benchmark::State& state) {
  const PreparedShading& p = PrepareShading(state.range(0));
  ForPoints(state, [&](size_t i) {
    benchmark::DoNotOptimize(p.shader->SurfaceOf(p.points[i].triangle, p.points[i].at, p.footprints[i]));
  });
}
BENCHMARK(SurfaceOfPoint)->Arg(0)->Arg(1);

/// The same without a footprint: one bilinear look into each texture.
void SurfaceOfPointMagnified(benchmark::State& state) {
  const PreparedShading& p = PrepareShading(state.range(0));
  ForPoints(state, [&](size_t i) {
    benchmark::DoNotOptimize(p.shader->SurfaceOf(p.points[i].triangle, p.points[i].at, {}));
  });
}
BENCHMARK(SurfaceOfPointMagnified)->Arg(0)->Arg(1);

void FootprintOfPoint(benchmark::State& state) {
  const PreparedShading& p = PrepareShading(state.range(0));
  ForPoints(state, [&](size_t i) {
    benchmark::DoNotOptimize(
        PixelFootprintAt(p.shader->frame(), p.points[i].triangle, p.points[i].at, kMidShutter));
  });
}
BENCHMARK(FootprintOfPoint)->Arg(0)->Arg(1);

/// Of the scene's largest image.
void MakePyramid(benchmark::State& state) {
  const std::vector<TextureImage>& images = PrepareShading(0).shader->frame().scene->images;
  const auto largest = std::max_element(images.begin(), images.end(),
                                        [](const auto& a, const auto& b) { return a.width < b.width; });
  for (auto _ : state) benchmark::DoNotOptimize(MipPyramid(*largest, TextureEncoding::kSrgb));
}
BENCHMARK(MakePyramid)->UseRealTime();

}  // namespace
}  // namespace shutterline::engine
