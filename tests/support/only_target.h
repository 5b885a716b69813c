#pragma once

#include <hwy/targets.h>

#include <cstdint>

namespace shutterline::engine {

/// Lets kernels run on one instruction set only, until it goes out of scope.
class OnlyTarget {
 public:
  explicit OnlyTarget(int64_t target) { Choose(target); }
  ~OnlyTarget() { Choose(0); }
  OnlyTarget(const OnlyTarget&) = delete;
  OnlyTarget& operator=(const OnlyTarget&) = delete;

 private:
  static void Choose(int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

/// Calls visit() once on each instruction set of this machine.
template <typename Visit>
void ForEachTarget(const Visit& visit) {
  const int64_t supported = hwy::SupportedTargets();
  for (int bit = 0; bit < 63; ++bit) {
    if ((supported >> bit & 1) == 0) continue;
    const OnlyTarget only(int64_t{1} << bit);
    visit();
  }
}

}  // namespace shutterline::engine
