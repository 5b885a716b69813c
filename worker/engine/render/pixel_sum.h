#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "common/base/check.h"
#include "common/math/spaces.h"

namespace shutterline::engine {

/// Sums what triangles add to a pixel, whatever the order in which they come. Keeps its memory.
class PixelSum {
 public:
  void Clear() {
    contributions_.clear();
    covered_ = 0;
  }
  void Add(uint64_t weight, const V3f& color) {
    contributions_.push_back({weight, color});
    covered_ += weight;
  }

  /// Red, green, blue and alpha over the background, which is nothing: what was added, and `film`, radiance
  /// and coverage, of `total`.
  void Write(const std::array<double, 4>& film, uint64_t total, std::span<float> pixel) {
    const uint64_t covered = covered_ + uint64_t(film[3]);
    SL_CHECK(covered <= total);
    // In an order that depends on what is added only, not on how triangles are numbered: sums of equal sets
    // of contributions are then equal to the last bit.
    std::sort(contributions_.begin(), contributions_.end());
    double r = film[0];
    double g = film[1];
    double b = film[2];
    for (const Contribution& c : contributions_) {
      r += double(c.weight) * double(c.color.x);
      g += double(c.weight) * double(c.color.y);
      b += double(c.weight) * double(c.color.z);
    }
    const auto whole = double(total);
    pixel[0] = float(r / whole);
    pixel[1] = float(g / whole);
    pixel[2] = float(b / whole);
    pixel[3] = float(double(covered) / whole);
  }

 private:
  struct Contribution {
    uint64_t weight;
    V3f color;

    bool operator<(const Contribution& o) const {
      return std::tie(weight, color.x, color.y, color.z) <
             std::tie(o.weight, o.color.x, o.color.y, o.color.z);
    }
  };

  std::vector<Contribution> contributions_;
  uint64_t covered_ = 0;
};

}  // namespace shutterline::engine
