#include "worker/engine/accel/facing.h"

#include <cmath>
#include <limits>

#include "common/math/bezier.h"

namespace shutterline::engine {
namespace {

/// Relative to the sum of the magnitudes of a determinant's terms. Instants are decided in single steps that
/// lose some more digits than this one, so it is wide: what turns edge-on within it is kept.
constexpr double kFacingSlack = 0x1p-40;

struct Determinant {
  double value = 0, magnitude = 0;

  void Add(double factor, const RasterPoint& a, const RasterPoint& b, const RasterPoint& c) {
    const double bc = b.y * c.w, cb = b.w * c.y;
    const double ca = b.w * c.x, ac = b.x * c.w;
    const double xy = b.x * c.y, yx = b.y * c.x;
    value += factor * (a.x * (bc - cb) + a.y * (ca - ac) + a.w * (xy - yx));
    magnitude += factor * (std::abs(a.x) * (std::abs(bc) + std::abs(cb)) +
                           std::abs(a.y) * (std::abs(ca) + std::abs(ac)) +
                           std::abs(a.w) * (std::abs(xy) + std::abs(yx)));
  }
  /// Raster y points down: fronts, counter-clockwise with y up, have negative determinants.
  bool IsBack() const { return value > kFacingSlack * magnitude; }
};

double Binomial(int n, int k) {
  double b = 1;
  for (int i = 1; i <= k; ++i) b = b * (n - k + i) / i;
  return b;
}

bool PieceShowsItsBack(const std::array<const RasterPoint*, 3>& p, int degree) {
  // Most triangles show their front at once.
  Determinant first;
  first.Add(1, p[0][0], p[1][0], p[2][0]);
  if (!first.IsBack()) return false;
  for (int power = 1; power <= 3 * degree; ++power) {
    // A coefficient, but for a positive factor.
    Determinant sum;
    for (int i = 0; i <= degree; ++i) {
      for (int j = 0; j <= degree; ++j) {
        const int k = power - i - j;
        if (k < 0 || k > degree) continue;
        sum.Add(Binomial(degree, i) * Binomial(degree, j) * Binomial(degree, k), p[0][i], p[1][j], p[2][k]);
      }
    }
    if (!sum.IsBack()) return false;
  }
  return true;
}

}  // namespace

bool ShowsItsBackAlways(const std::array<const RasterPoint*, 3>& points, int degree, int pieces) {
  for (int piece = 0; piece < pieces; ++piece) {
    std::array<const RasterPoint*, 3> part = points;
    for (const RasterPoint*& p : part) p += piece * degree;
    if (!PieceShowsItsBack(part, degree)) return false;
  }
  return true;
}

}  // namespace shutterline::engine
