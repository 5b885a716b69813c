#include "common/job/render_stats.h"

#include <algorithm>
#include <limits>

namespace shutterline {

RenderStats& RenderStats::operator+=(const RenderStats& other) {
  for (const auto& field : kRenderCounts) {
    int64_t& sum = this->*field.member;
    if (__builtin_add_overflow(sum, other.*field.member, &sum)) sum = std::numeric_limits<int64_t>::max();
  }
  for (const auto& field : kRenderSeconds) {
    double& sum = this->*field.member;
    sum = std::min(sum + other.*field.member, kMaxStatsSeconds);
  }
  return *this;
}

double RenderStats::TotalSeconds() const {
  double total = 0;
  for (const auto& field : kRenderSeconds) total += this->*field.member;
  return total;
}

}  // namespace shutterline
