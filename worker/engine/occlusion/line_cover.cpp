#include "worker/engine/occlusion/line_cover.h"

#include <algorithm>

namespace shutterline::engine {

void LineCover::Add(int32_t begin, int32_t end) {
  if (begin >= end) return;
  // The intervals that it meets or touches become one. They are few: neighbouring triangles have merged.
  auto first = intervals_.begin();
  while (first != intervals_.end() && first->end < begin) ++first;
  if (first == intervals_.end() || first->begin > end) {
    intervals_.insert(first, {begin, end});
    return;
  }
  if (first->begin <= begin && first->end >= end) return;
  auto last = first + 1;
  while (last != intervals_.end() && last->begin <= end) ++last;
  first->begin = std::min(first->begin, begin);
  first->end = std::max((last - 1)->end, end);
  if (last != first + 1) intervals_.erase(first + 1, last);
}

}  // namespace shutterline::engine
