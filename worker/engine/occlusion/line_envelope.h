#pragma once

#include <cstdint>
#include <vector>

#include "worker/engine/occlusion/falloff.h"

namespace shutterline::engine {

/// The share of a line, of kWholeLine, that the nearest of `segments` take in each direction, weighed by
/// 1 - ρ(d). They may cross. Sorts the segments; their order does not matter.
int64_t OcclusionOfNearest(std::vector<DistanceSegment>& segments, const FalloffRule& rule);

}  // namespace shutterline::engine
