// Whole cells: closed forms, and a million pieces.
#include "worker/engine/paper/cell_resolver.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numeric>

namespace shutterline::engine::paper {
namespace {

Slab Rectangle(double l0, double l1, double t0, double t1, double depth) {
  return {t0, t1, l0, l0, l1, l1, depth, depth, depth, depth};
}

std::vector<double> Areas(const std::vector<PatchPiece>& pieces, const Options& options = {},
                          const CellBounds& cell = {}) {
  CellResolver resolver(options);
  std::vector<uint32_t> all(pieces.size());
  std::iota(all.begin(), all.end(), 0u);
  resolver.Resolve(cell, all, pieces);
  std::vector<double> areas(pieces.size());
  for (const VisibleFragment& f : resolver.fragments()) areas[f.index] += f.area;
  return areas;
}

TEST(Cells, NearerCoversFarther) {
  const auto areas = Areas({{Rectangle(-1, 0.25, 0, 1, 0.9), 0, 0}, {Rectangle(-1, 2, 0.5, 1, 0.5), 1, 1}});
  EXPECT_NEAR(areas[0], 0.25, 1e-15);
  EXPECT_NEAR(areas[1], 0.375, 1e-15);
}

TEST(Cells, DepthsThatCross) {
  // Depths l and t over the unit cell: each is nearer on its side of the diagonal.
  const Slab by_l{0, 1, 0, 0, 1, 1, 0, 0, 1, 1};
  const Slab by_t{0, 1, 0, 0, 1, 1, 0, 1, 0, 1};
  const auto areas = Areas({{by_l, 0, 0}, {by_t, 1, 1}});
  EXPECT_NEAR(areas[0], 0.5, 1e-14);
  EXPECT_NEAR(areas[1], 0.5, 1e-14);
}

TEST(Cells, TwistedDepthFollowsTheHyperbola) {
  // Depth 1 − l·t against ½: nearer where l·t < ½, which is ½ + ½ ln 2 of the cell. Two patch triangles give
  // ¾ or 7/8; planes that follow depth converge.
  const Slab twisted{0, 1, 0, 0, 1, 1, 1, 1, 1, 0};
  const double expected = 0.5 + 0.5 * std::log(2.0);
  double last = 1;
  for (const int halvings : {2, 4, 6, 8, 10}) {
    const auto areas = Areas({{twisted, 0, 0}, {Rectangle(-1, 2, 0, 1, 0.5), 1, 1}},
                             {.depth_tolerance = 1e-9, .plane_halvings = halvings});
    const double error = std::abs(areas[0] - expected);
    EXPECT_LE(error, 0.1 * std::exp2(-0.5 * halvings)) << halvings;
    EXPECT_NEAR(areas[0] + areas[1], 1, 1e-12);
    last = error;
  }
  EXPECT_LE(last, 1e-3);
}

TEST(Cells, OneTriangleNeedsNoOrder) {
  const auto areas =
      Areas({{Rectangle(0, 0.5, 0, 0.5, 0.5), 0, 0}, {Rectangle(0.25, 0.5, 0.5, 1, 0.5), 0, 0}});
  EXPECT_NEAR(areas[0], 0.375, 1e-15);
}

TEST(Cells, Row34MillionDisjointTiles) {
  // 1000 × 1000 tiles of one cell, each on a plane of its own that cuts others: every tile is seen whole,
  // nothing is left of the cell, and it takes about as long for each.
  const auto seconds = [](int side) {
    std::vector<PatchPiece> pieces;
    for (int i = 0; i < side; ++i) {
      for (int j = 0; j < side; ++j) {
        const double l0 = double(i) / side;
        const double l1 = double(i + 1) / side;
        const double t0 = double(j) / side;
        const double t1 = double(j + 1) / side;
        const double d = 0.4 + 0.2 * ((i * 31 + j * 17) % 101) / 101.0;
        const auto number = uint32_t(pieces.size());
        pieces.emplace_back(Slab{t0, t1, l0, l0, l1, l1, d, d + 0.01, d + 0.02, d + 0.03}, number, number);
      }
    }
    const auto start = std::chrono::steady_clock::now();
    const auto areas = Areas(pieces);
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double each = 1.0 / (double(side) * side);
    double sum = 0;
    for (const double area : areas) {
      EXPECT_NEAR(area, each, 1e-12);
      sum += area;
    }
    EXPECT_NEAR(sum, 1, 1e-9);
    return took;
  };
  const double small = seconds(100);
  const double large = seconds(1000);
  std::cout << "10^4 tiles: " << small << " s, 10^6 tiles: " << large << " s\n";
  // N log N would be 150 times as long; quadratic 10,000 times.
  EXPECT_LE(large, 1500 * small);
}

TEST(Cells, FanOfThinBladesIsCovered) {
  // Thousands of pieces that meet in one point, where halving does not tell them apart.
  constexpr int kBlades = 2000;
  std::vector<PatchPiece> pieces;
  for (uint32_t i = 0; i < kBlades; ++i) {
    const double a = double(i) / kBlades;
    const double b = double(i + 1) / kBlades;
    pieces.emplace_back(Slab{0, 1, 0, a, 0, b, 0.5, 0.5, 0.5, 0.5}, i, i);
  }
  const auto areas = Areas(pieces);
  const double sum = std::accumulate(areas.begin(), areas.end(), 0.0);
  EXPECT_NEAR(sum, 0.5, 1e-9);
}

}  // namespace
}  // namespace shutterline::engine::paper
