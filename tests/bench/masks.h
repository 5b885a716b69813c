#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/point_probe.h"
#include "tests/bench/tile_subset.h"

namespace shutterline::bench {

/// Which pixels are what, a byte a pixel of the stack; found by rays, without any of the methods compared.
/// Of every pixel kMaskPoints points in (x, y, t) are looked at.
struct BenchMasks {
  /// Sees, at some instant, a surface that moves by a pixel or more over the shutter.
  std::vector<uint8_t> moving;
  /// Not moving, and what it sees differs by more than 1/50 in some channel: an edge that stands still.
  std::vector<uint8_t> static_edges;
  /// Moving, and it also sees background or a surface whose motion differs by a pixel or more: something
  /// is covered or uncovered while the shutter is open.
  std::vector<uint8_t> disocclusions;
};

inline constexpr int kMaskPoints = 64;

BenchMasks MakeMasks(const PointProbe& probe, int frame, const TileSubset& subset, int threads);

/// Part of the pixels that a mask takes.
double MaskShare(const std::vector<uint8_t>& mask);

}  // namespace shutterline::bench
