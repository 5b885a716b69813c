#include "tests/support/patch_accuracy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "common/job/tile.h"
#include "worker/engine/paper/line_patches.h"

namespace shutterline::engine {
namespace {

/// The nearest segment at (l, t), by making all of them.
std::optional<paper::PatchSight> Truth(const TileTriangles& tile, const SegmentLine& line, int family,
                                       int64_t number, double l, double t) {
  std::optional<paper::PatchSight> best;
  for (uint32_t i = 0; i < tile.triangles.size(); ++i) {
    const TileTriangle& triangle = tile.triangles[i];
    if (best && triangle.nearest_depth < best->depth) break;
    if (triangle.first_line[size_t(family)] > number || triangle.last_line[size_t(family)] < number) continue;
    if (triangle.moves && (t < triangle.t_in || t > triangle.t_out)) continue;
    LineSegment segment;
    if (!MakeSegment(triangle, i, tile.far_depth, line, t, &segment, nullptr)) continue;
    if (l < segment.l0 || l >= segment.l1) continue;
    const double depth = segment.DepthAt(l);
    if (!best || depth > best->depth || (depth == best->depth && triangle.id < best->triangle)) {
      best = paper::PatchSight{triangle.id, depth};
    }
  }
  return best;
}

}  // namespace

PatchAccuracy MeasurePatches(const FrameScene& frame, PatternKind pattern_kind, const paper::Options& options,
                             int samples_per_line, uint64_t seed, int stride) {
  const LinePattern& pattern = LinePattern::Get(pattern_kind);
  std::vector<PrimitiveTraits> traits;
  for (const FramePrimitive& primitive : frame.primitives) {
    traits.push_back({.cull_back = !primitive.material->double_sided});
  }
  std::vector<uint32_t> all(frame.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);

  PatchAccuracy accuracy;
  std::vector<double> errors;  // Distances.
  double low = std::numeric_limits<double>::infinity();
  double high = 0;
  RenderStats stats;
  int number = 0;
  for (int y = 0; y < frame.view.height; y += kTileSize) {
    for (int x = 0; x < frame.view.width; x += kTileSize) {
      if (number++ % stride != 0) continue;
      const TileRect rect{x, y, std::min(kTileSize, frame.view.width - x),
                          std::min(kTileSize, frame.view.height - y)};
      TileTriangles tile;
      SetUpTile(frame, traits, pattern, rect, all, tile);
      std::vector<uint32_t> candidates(tile.triangles.size());
      std::iota(candidates.begin(), candidates.end(), 0u);
      paper::LinePatches patches(pattern, tile, options, stats);
      for (const TileLine& line : pattern.LinesIn(rect)) {
        patches.Gather(line, candidates);
        for (int i = 0; i < samples_per_line; ++i) {
          const double l = line.first_step + unit(random) * (line.end_step - line.first_step);
          const double t = unit(random);
          const auto seen = patches.SeeAt(l, t);
          const auto truth = Truth(tile, patches.line(), line.family, line.number, l, t);
          ++accuracy.points;
          accuracy.agreeing +=
              seen.has_value() == truth.has_value() && (!seen || seen->triangle == truth->triangle);
          if (!patches.moves() || (!seen && !truth)) continue;
          ++accuracy.samples;
          if (!seen || !truth) continue;
          accuracy.same_triangle += seen->triangle == truth->triangle;
          const double distance = frame.view.znear / truth->depth;
          errors.push_back(std::abs(frame.view.znear / seen->depth - distance));
          low = std::min(low, distance);
          high = std::max(high, distance);
        }
      }
    }
  }
  // Where all is about equally far a range of distances says nothing: a hundredth of the distance is meant.
  const double range = std::max(high - low, high / 100);
  for (const double error : errors) {
    const double of_range = error / range;
    accuracy.depth_within_thousandth += of_range < 1e-3;
    accuracy.largest_depth_error = std::max(accuracy.largest_depth_error, of_range);
  }
  return accuracy;
}

}  // namespace shutterline::engine
