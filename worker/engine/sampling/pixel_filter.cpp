#include "worker/engine/sampling/pixel_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/check.h"

namespace shutterline::engine {
namespace {

/// The Gaussian's standard deviation, in radii: it is cut off at three of them.
constexpr double kGaussianDeviation = 1.0 / 3;

/// The window of four terms of Blackman and Harris, which has its least side lobes.
constexpr double kBlackmanHarris[] = {0.35875, 0.48829, 0.14128, 0.01168};

}  // namespace

double FilterIntegral(FilterKind kind, double radius, double x) {
  x = std::clamp(x, -radius, radius);
  switch (kind) {
    case FilterKind::kBox:
      return x + radius;
    case FilterKind::kTriangle: {
      const double to_end = 1 - std::abs(x) / radius;
      const double tail = 0.5 * radius * to_end * to_end;
      return x < 0 ? tail : radius - tail;
    }
    case FilterKind::kGaussian: {
      const double deviation = kGaussianDeviation * radius;
      const double scale = 1 / (deviation * std::numbers::sqrt2);
      const double lift = std::exp(-0.5 / (kGaussianDeviation * kGaussianDeviation));
      const double area = deviation / std::numbers::inv_sqrtpi * std::numbers::sqrt2 / 2;
      return area * (std::erf(x * scale) + std::erf(radius * scale)) - lift * (x + radius);
    }
    case FilterKind::kBlackmanHarris: {
      double sum = kBlackmanHarris[0] * (x + radius);
      for (int i = 1; i < 4; ++i) {
        const double frequency = i * std::numbers::pi / radius;
        sum += kBlackmanHarris[i] * std::sin(frequency * x) / frequency;
      }
      return sum;
    }
  }
  SL_CHECK(false);
  return 0;
}

PixelFilter::PixelFilter(FilterKind kind, double radius) : reach_(int(std::ceil(radius - 0.5))) {
  SL_CHECK(radius >= kMinFilterRadius && reach_ <= kMostReach);
  // Half a pixel's cells; the other half is its mirror image. A share is the rounded sum up to the end of its
  // cell minus that to its beginning, so roundings do not add up, and it is not negative.
  std::array<double, kMostTaps> sums{};
  for (int c = 0; c < kCells / 2; ++c) {
    std::array<double, kMostTaps> parts{};
    double all = 0;
    for (int k = 0; k < taps(); ++k) {
      const double middle = k - reach_ + 0.5;
      parts[size_t(k)] = FilterIntegral(kind, radius, double(c + 1) / kCells - middle) -
                         FilterIntegral(kind, radius, double(c) / kCells - middle);
      all += parts[size_t(k)];
    }
    Cell& cell = cells_[size_t(c)];
    cell.share[size_t(reach_)] = kWhole;
    for (int k = 0; k < taps(); ++k) {
      if (k == reach_) continue;
      double& sum = sums[size_t(k)];
      const double before = std::round(sum);
      sum += kWhole * parts[size_t(k)] / all;
      cell.share[size_t(k)] = std::round(sum) - before;
      cell.share[size_t(reach_)] -= cell.share[size_t(k)];
    }
    SL_CHECK(cell.share[size_t(reach_)] >= 0);
    for (int k = 0; k < taps(); ++k) {
      cells_[size_t(kCells - 1 - c)].share[size_t(taps() - 1 - k)] = cell.share[size_t(k)];
    }
  }
  for (int c = kCells - 2; c >= 0; --c) {
    for (size_t k = 0; k < kMostTaps; ++k) {
      cells_[size_t(c)].later[k] = cells_[size_t(c) + 1].later[k] + cells_[size_t(c) + 1].share[k];
    }
  }
  // From the farthest place before the pixel on, which has the pixel as its last tap.
  before_.push_back(0);
  for (int k = taps() - 1; k >= 0; --k) {
    for (int c = 0; c < kCells; ++c) {
      before_.push_back(before_.back() + uint32_t(cells_[size_t(c)].share[size_t(k)]));
    }
  }
}

uint32_t PixelFilter::SumOfStrip(int strips, int strip, int tap) const {
  const int cells = kCells / strips;
  double sum = 0;
  for (int c = strip * cells; c < (strip + 1) * cells; ++c) sum += cells_[size_t(c)].share[size_t(tap)];
  return uint32_t(sum);
}

double PixelFilter::PlaceOf(double u) const {
  const double wanted = u * double(before_.back());
  // The last cell that begins at or before what is wanted is not empty.
  const auto next = std::upper_bound(before_.begin(), before_.end(), wanted,
                                     [](double a, uint32_t b) { return a < double(b); });
  const auto cell = size_t(next - before_.begin()) - 1;
  const double part = (wanted - before_[cell]) / double(before_[cell + 1] - before_[cell]);
  return (double(cell) + part) / kCells - reach_;
}

}  // namespace shutterline::engine
