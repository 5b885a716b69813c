#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>

#include "common/base/work_limit.h"

namespace shutterline::engine {

/// Calls `f(i)` for all `i` below `count`, in parallel, within the limit of who calls.
template <typename F>
void ForEach(size_t count, F f) {
  const WorkLimit* const limit = WorkLimit::Current();
  tbb::parallel_for(size_t{0}, count, [&](size_t i) {
    CheckWork(limit);
    const WorkLimitScope scope(limit);
    f(i);
  });
}

}  // namespace shutterline::engine
