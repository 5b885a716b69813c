#include "worker/engine/sampling/pixel_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "common/job/render_settings.h"

namespace shutterline::engine {
namespace {

struct Filter {
  FilterKind kind;
  double radius;
};

std::vector<Filter> AllFilters() {
  std::vector<Filter> filters;
  for (const FilterKind kind :
       {FilterKind::kBox, FilterKind::kTriangle, FilterKind::kGaussian, FilterKind::kBlackmanHarris}) {
    for (const double radius : {0.5, 0.51, 0.8, 1.0, 1.3, 1.5, 2.0, 2.7, 3.5, 4.0}) {
      filters.push_back({kind, radius});
    }
  }
  return filters;
}

std::string Name(const Filter& filter) {
  return std::string(ToString(filter.kind)) + " " + std::to_string(filter.radius);
}

/// What a pixel takes of all that lies before x, pixels from its middle, by its cells.
double Taken(const PixelFilter& filter, double x) {
  const double from_border = x + 0.5 + filter.reach();
  const auto pixel = int(std::floor(from_border));
  double sum = 0;
  for (int k = 0; k < pixel && k < filter.taps(); ++k) sum += filter.Sum(filter.taps() - 1 - k);
  if (pixel < filter.taps()) {
    const double in_cells = (from_border - pixel) * PixelFilter::kCells;
    const auto tap = size_t(filter.taps() - 1 - pixel);
    for (int c = 0; c < int(in_cells); ++c) sum += filter.At(c).share[tap];
    sum += (in_cells - std::floor(in_cells)) * filter.At(int(in_cells)).share[tap];
  }
  return sum / (PixelFilter::kCells * PixelFilter::kWhole);
}

TEST(PixelFilter, SharesOfAPlaceAddUpToTheWhole) {
  for (const Filter& of : AllFilters()) {
    const PixelFilter filter(of.kind, of.radius);
    EXPECT_EQ(filter.reach(), int(std::ceil(of.radius - 0.5)));
    double all = 0;
    for (int c = 0; c < PixelFilter::kCells; ++c) {
      double sum = 0;
      for (int k = 0; k < filter.taps(); ++k) {
        const double share = filter.At(c).share[size_t(k)];
        EXPECT_GE(share, 0) << Name(of);
        EXPECT_EQ(share, filter.At(PixelFilter::kCells - 1 - c).share[size_t(filter.taps() - 1 - k)]);
        sum += share;
      }
      EXPECT_EQ(sum, PixelFilter::kWhole) << Name(of) << " cell " << c;
      all += sum;
    }
    double strips = 0;
    for (int strip = 0; strip < 16; ++strip) {
      for (int k = 0; k < filter.taps(); ++k) strips += filter.SumOfStrip(16, strip, k);
    }
    EXPECT_EQ(strips, all);
  }
}

/// Where the curve's translates by whole pixels add up to a constant, dividing by their sum changes nothing.
TEST(PixelFilter, TakesTheIntegralOfItsCurve) {
  const std::vector<Filter> filters = {{FilterKind::kBox, 0.5},          {FilterKind::kBox, 1},
                                       {FilterKind::kBox, 3.5},          {FilterKind::kTriangle, 1},
                                       {FilterKind::kTriangle, 2},       {FilterKind::kTriangle, 4},
                                       {FilterKind::kBlackmanHarris, 2}, {FilterKind::kBlackmanHarris, 2.5},
                                       {FilterKind::kBlackmanHarris, 4}};
  for (const Filter& of : filters) {
    const PixelFilter filter(of.kind, of.radius);
    const double whole = FilterIntegral(of.kind, of.radius, of.radius);
    for (double x = -of.radius; x <= of.radius; x += 0.0137) {
      EXPECT_NEAR(Taken(filter, x), FilterIntegral(of.kind, of.radius, x) / whole, 1.5e-4)
          << Name(of) << " " << x;
    }
  }
}

/// Elsewhere what the division changes is what the translates' sum varies by.
TEST(PixelFilter, TheGaussianIsNearlyItsOwnCurve) {
  const PixelFilter filter(FilterKind::kGaussian, 1.5);
  const double whole = FilterIntegral(FilterKind::kGaussian, 1.5, 1.5);
  double most = 0;
  for (double x = -1.5; x <= 1.5; x += 0.01) {
    most = std::max(most, std::abs(Taken(filter, x) - FilterIntegral(FilterKind::kGaussian, 1.5, x) / whole));
  }
  EXPECT_LT(most, 0.01);
}

TEST(PixelFilter, IntegralsAreThoseOfTheCurves) {
  for (const Filter& of : AllFilters()) {
    const double r = of.radius;
    const auto curve = [&](double x) {
      switch (of.kind) {
        case FilterKind::kBox:
          return 1.0;
        case FilterKind::kTriangle:
          return 1 - std::abs(x) / r;
        case FilterKind::kGaussian:
          return std::exp(-4.5 * x * x / (r * r)) - std::exp(-4.5);
        case FilterKind::kBlackmanHarris: {
          const double a = M_PI * x / r;
          return 0.35875 + 0.48829 * std::cos(a) + 0.14128 * std::cos(2 * a) + 0.01168 * std::cos(3 * a);
        }
      }
      return 0.0;
    };
    constexpr int kSteps = 4000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      sum += curve(-r + (i + 0.5) * 2 * r / kSteps) * 2 * r / kSteps;
      if (i % 100 == 99) {
        EXPECT_NEAR(FilterIntegral(of.kind, r, -r + (i + 1) * 2 * r / kSteps), sum, 1e-5 * r) << Name(of);
      }
    }
    EXPECT_EQ(FilterIntegral(of.kind, r, -r - 1), FilterIntegral(of.kind, r, -r));
    EXPECT_EQ(FilterIntegral(of.kind, r, r + 1), FilterIntegral(of.kind, r, r));
  }
}

TEST(PixelFilter, PlacesAreAsDenseAsShares) {
  std::mt19937 random(7);
  for (const Filter& of : AllFilters()) {
    const PixelFilter filter(of.kind, of.radius);
    double last = -filter.reach() - 1;
    for (int i = 0; i < 500; ++i) {
      const double u = (i + std::uniform_real_distribution<double>(0, 1)(random)) / 500;
      const double place = filter.PlaceOf(u);
      EXPECT_GE(place, last);
      EXPECT_LE(std::abs(place - 0.5), filter.reach() + 0.5);
      EXPECT_NEAR(Taken(filter, place - 0.5), u, 1e-9) << Name(of);
      last = place;
    }
  }
}

}  // namespace
}  // namespace shutterline::engine
