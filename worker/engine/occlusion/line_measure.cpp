#include "worker/engine/occlusion/line_measure.h"

#include <array>
#include <cmath>
#include <numbers>

namespace shutterline::engine {
namespace {

constexpr int kTerms = 22;

/// Coefficients of the arc sine's power series: asin x = x Σ c_n x^2n.
constexpr std::array<double, kTerms> kArcSine = [] {
  std::array<double, kTerms> c{};
  double binomial = 1;  // (2n)! / (2^n n!)².
  for (int n = 0; n < kTerms; ++n) {
    c[size_t(n)] = binomial / (2 * n + 1);
    binomial *= (2.0 * n + 1) / (2.0 * n + 2);
  }
  return c;
}();

/// For |x| <= ½, where the terms that are left out are below 2^-50.
double ArcSineNearZero(double x) {
  const double xx = x * x;
  double sum = 0;
  for (int n = kTerms; n-- > 0;) sum = kArcSine[size_t(n)] + xx * sum;
  return x * sum;
}

double ArcSine(double x) {
  const double a = std::abs(x);
  if (a <= 0.5) return ArcSineNearZero(x);
  return std::copysign(std::numbers::pi / 2 - 2 * ArcSineNearZero(std::sqrt((1 - a) / 2)), x);
}

}  // namespace

int64_t ShareBelow(OcclusionPattern pattern, int32_t l) {
  const double x = l * kLineUnit;
  double twice;  // In [-1, 1].
  if (pattern == OcclusionPattern::kPole) {
    twice = x * std::abs(x);
  } else {
    twice = (ArcSine(x) + x * std::sqrt((1 - x) * (1 + x))) / (std::numbers::pi / 2);
  }
  return std::llround((0.5 + 0.5 * twice) * double(kWholeLine));
}

double DensityAt(OcclusionPattern pattern, double l, double height) {
  if (pattern == OcclusionPattern::kPole) return std::abs(l) * height;
  return height * height / (std::numbers::pi / 2);
}

}  // namespace shutterline::engine
