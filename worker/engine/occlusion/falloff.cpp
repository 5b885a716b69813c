#include "worker/engine/occlusion/falloff.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/engine/occlusion/line_measure.h"

namespace shutterline::engine {
namespace {

/// Gauss' rule of five points on [-1, 1]: nodes ±0, ±√(5 ∓ 2√(10/7))/3.
constexpr std::array<double, 5> kNodes{-0.906179845938664, -0.5384693101056831, 0, 0.5384693101056831,
                                       0.906179845938664};
constexpr std::array<double, 5> kWeights{0.23692688505618908, 0.47862867049936647, 0.5688888888888889,
                                         0.47862867049936647, 0.23692688505618908};
/// Halving a half circle so often leaves nothing.
constexpr int kMostCuts = 40;

double InverseDistance(const DistanceSegment& segment, const LineDirection& d) {
  return segment.inverse_along * d.along + segment.inverse_up * d.up;
}

LineDirection Unit(double along, double up) {
  const double length = std::sqrt(along * along + up * up);
  return {along / length, up / length};
}

/// Directions run along the chord between the panel's ends, at even steps.
double PanelOcclusion(const DistanceSegment& segment, const LineDirection& a, const LineDirection& b,
                      const FalloffRule& rule) {
  const LineDirection middle{0.5 * (a.along + b.along), 0.5 * (a.up + b.up)};
  const LineDirection half{0.5 * (b.along - a.along), 0.5 * (b.up - a.up)};
  const double turn = std::abs(middle.along * half.up - middle.up * half.along);
  double sum = 0;
  for (size_t i = 0; i < kNodes.size(); ++i) {
    const double along = middle.along + kNodes[i] * half.along, up = middle.up + kNodes[i] * half.up;
    const double square = along * along + up * up, length = std::sqrt(square);
    const LineDirection d{along / length, up / length};
    const double inverse = InverseDistance(segment, d) * rule.radius;
    double open = inverse > 1 ? 1 / inverse : 1;
    if (rule.falloff == OcclusionFalloff::kQuadratic) open *= open;
    sum += kWeights[i] * (1 - open) * DensityAt(rule.pattern, d.along, d.up) / square;
  }
  return turn * sum;
}

double CutAndSum(const DistanceSegment& segment, const LineDirection& a, const LineDirection& b,
                 const FalloffRule& rule, int cuts) {
  // Farther than the radius is as good as at it.
  const double least = 1 / rule.radius;
  const double at_a = std::max(InverseDistance(segment, a), least);
  const double at_b = std::max(InverseDistance(segment, b), least);
  const bool is_narrow = a.along * b.along + a.up * b.up > 0.7071;
  if ((is_narrow && at_a <= 2 * at_b && at_b <= 2 * at_a) || cuts == kMostCuts) {
    return PanelOcclusion(segment, a, b, rule);
  }
  // Half of a half circle points up.
  const double along = a.along + b.along, up = a.up + b.up;
  const LineDirection middle = along * along + up * up > 1e-12 ? Unit(along, up) : LineDirection{0, 1};
  return CutAndSum(segment, a, middle, rule, cuts + 1) + CutAndSum(segment, middle, b, rule, cuts + 1);
}

}  // namespace

double OcclusionOfPiece(const DistanceSegment& segment, const LineDirection& a, const LineDirection& b,
                        const FalloffRule& rule) {
  // The measure of lines through the pole has a kink there.
  if (rule.pattern == OcclusionPattern::kPole && a.along < 0 && b.along > 0) {
    const LineDirection pole{0, 1};
    return CutAndSum(segment, a, pole, rule, 0) + CutAndSum(segment, pole, b, rule, 0);
  }
  return CutAndSum(segment, a, b, rule, 0);
}

}  // namespace shutterline::engine
