#include "worker/engine/stochastic/pass_shape.h"

#include <algorithm>
#include <limits>

namespace shutterline::engine {
namespace {

// What things take, in nanoseconds, roughly, on one core with AVX-512: ratios are what counts.
constexpr double kBoundTriangle = 1.0;
constexpr double kVisitTriangle = 4.0;
constexpr double kVisitBlock = 2.5;
constexpr double kTestVector = 6.0;
/// So many triangles tell enough of all.
constexpr size_t kProbes = 64;

}  // namespace

PassShape ChoosePassShape(const CellTriangles& cell, int spp) {
  PassShape best;
  double least = std::numeric_limits<double>::infinity();
  const size_t count = cell.triangles.size();
  const size_t step = std::max<size_t>(1, count / kProbes);
  for (int block_log2 = 2; block_log2 >= 0; --block_log2) {
    for (int strata = kVectorSamples >> (2 * block_log2); strata <= kMostPassStrata; strata *= 2) {
      const PassShape shape{block_log2, strata};
      const double passes = double((spp + strata - 1) / strata);
      const double share = double(strata) / spp;
      const double block = shape.block();
      double cost = 0;
      for (size_t i = 0; i < count; i += step) {
        const auto& [width, height, path_x, path_y] = cell.extent[i];
        const auto blocks = [&](double size) {
          return std::min((size + block) / block, double(shape.blocks_per_side()));
        };
        const double visited = blocks(width + share * path_x) * blocks(height + share * path_y);
        cost += passes *
                (kBoundTriangle + kVisitTriangle + visited * (kVisitBlock + shape.vectors() * kTestVector));
      }
      if (cost < least) {
        least = cost;
        best = shape;
      }
    }
  }
  return best;
}

}  // namespace shutterline::engine
