#include "tests/bench/masks.h"

#include <algorithm>
#include <array>

#include "worker/engine/sampling/point_pattern.h"

namespace shutterline::bench {
namespace {

constexpr double kLeastMotion = 1;       // Pixels over the shutter.
constexpr float kLeastContrast = 0.02f;  // Linear.

struct PixelKind {
  bool moving = false, contrast = false, disoccluded = false;
};

PixelKind KindOf(const PointProbe& probe, std::span<const ProbePoint> points,
                 std::span<const ProbeHit> hits) {
  PixelKind kind;
  V3f low(1e30f), high(-1e30f);
  V2d least(1e30), most(-1e30);
  bool background = false;
  for (size_t i = 0; i < hits.size(); ++i) {
    const V3f color = probe.Radiance(hits[i], points[i].t);
    for (int c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], color[c]);
      high[c] = std::max(high[c], color[c]);
    }
    if (!hits[i].hit) {
      background = true;
      continue;
    }
    V2d motion = probe.Motion(hits[i]);
    // A point that passes the plane of the eye has no motion in the picture; it is fast.
    if (!(motion.length() < 1e6)) motion = V2d(1e6);
    kind.moving |= motion.length() >= kLeastMotion;
    for (int c = 0; c < 2; ++c) {
      least[c] = std::min(least[c], motion[c]);
      most[c] = std::max(most[c], motion[c]);
    }
  }
  const V3f range = high - low;
  kind.contrast = std::max({range.x, range.y, range.z}) > kLeastContrast;
  const bool differs = most.x >= least.x && (most - least).length() >= kLeastMotion;
  kind.disoccluded = kind.moving && (background || differs);
  return kind;
}

}  // namespace

BenchMasks MakeMasks(const PointProbe& probe, int frame, const TileSubset& subset, int threads) {
  const size_t pixels = subset.tiles.size() * kTileSize * kTileSize;
  BenchMasks masks{std::vector<uint8_t>(pixels), std::vector<uint8_t>(pixels), std::vector<uint8_t>(pixels)};
  const engine::PointPattern pattern(9000001, frame);
  ParallelFor(int(subset.tiles.size()), threads, [&](int index, int) {
    const TileRect& rect = subset.tiles[size_t(index)];
    std::array<ProbePoint, kMaskPoints> points;
    std::array<ProbeHit, kMaskPoints> hits;
    for (int y = 0; y < rect.height; ++y) {
      for (int x = 0; x < rect.width; ++x) {
        const engine::PixelPoints random = pattern.Pixel(rect.x + x, rect.y + y);
        for (int i = 0; i < kMaskPoints; ++i) {
          const engine::PixelPoint p = random.At(uint32_t(i));
          points[size_t(i)] = {rect.x + x + p.x, rect.y + y + p.y, p.t};
        }
        probe.See(points, hits);
        const PixelKind kind = KindOf(probe, points, hits);
        const size_t pixel = (size_t(index) * kTileSize + size_t(y)) * kTileSize + size_t(x);
        masks.moving[pixel] = kind.moving;
        masks.static_edges[pixel] = !kind.moving && kind.contrast;
        masks.disocclusions[pixel] = kind.disoccluded;
      }
    }
  });
  return masks;
}

double MaskShare(const std::vector<uint8_t>& mask) {
  size_t count = 0;
  for (const uint8_t value : mask) count += value;
  return mask.empty() ? 0 : double(count) / double(mask.size());
}

}  // namespace shutterline::bench
