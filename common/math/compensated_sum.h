#pragma once

#include <cmath>

namespace shutterline {

/// A sum that carries the rounding error of each addition (Neumaier's variant of Kahan summation): the
/// result of n additions is within about 2 ulp of the sum plus n² · 2^-106 of the sum of magnitudes,
/// whatever the order. The order still decides the last bit, so keep it fixed where bits must agree.
class CompensatedSum {
 public:
  void Add(double value) {
    const double sum = sum_ + value;
    // The larger of the two survives the rounding whole; what the smaller one lost is exact to recover.
    correction_ += std::abs(sum_) >= std::abs(value) ? (sum_ - sum) + value : (value - sum) + sum_;
    sum_ = sum;
  }
  double Total() const { return sum_ + correction_; }

 private:
  double sum_ = 0, correction_ = 0;
};

}  // namespace shutterline
