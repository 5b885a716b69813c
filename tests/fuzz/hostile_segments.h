#pragma once

#include <cstdint>
#include <vector>

#include "tests/fuzz/hostile_values.h"

namespace shutterline::engine {

/// A segment as March takes it, with its id.
struct HostileSegment {
  int32_t begin = 0, end = 0;
  float depth = 0, slope = 0;
  uint32_t id = 0;
};

/// Segments of a line of `length` subpixels that meet in every unpleasant way. Depths stay within [0, 1], as
/// those of segments that come from triangles do; ids are different.
std::vector<HostileSegment> MakeHostileSegments(HostileValues& values, int32_t length, int count);

}  // namespace shutterline::engine
