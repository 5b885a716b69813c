#include "common/math/compensated_sum.h"

#include <gtest/gtest.h>

namespace shutterline {
namespace {

TEST(CompensatedSum, KeepsWhatPlainSumsDrop) {
  CompensatedSum sum;
  double plain = 0;
  for (const double value : {1.0, 1e100, 1.0, -1e100}) {
    sum.Add(value);
    plain += value;
  }
  EXPECT_EQ(sum.Total(), 2);
  EXPECT_EQ(plain, 0);
}

TEST(CompensatedSum, ManySmallValues) {
  CompensatedSum sum;
  for (int i = 0; i < 1000000; ++i) sum.Add(0.1);
  EXPECT_EQ(sum.Total(), 100000.0);  // 10^6 × (0.1 as a double) rounds to it.
}

}  // namespace
}  // namespace shutterline
