#pragma once

#include <cstdint>
#include <string>

/// What must hold of the innermost loops whatever they are given. Each returns what is broken, or nothing.
namespace shutterline::engine {

/// March on lists of segments that tie in place, depth and slope, are empty, steep, or cross within a
/// subpixel: it ends after a bounded number of pieces, in order, each within its segment, nearest up to the
/// rounding of depths as brute force finds it, the same on every instruction set and for any order.
std::string BrokenMarch(uint64_t seed);

/// The same of EnvelopeMarcher, its ancestor in double precision.
std::string BrokenEnvelope(uint64_t seed);

/// PlaceTriangles and MakeSegments on corners of any bits: segments lie on their lines, with depths of their
/// triangles.
std::string BrokenPlacedSegments(uint64_t seed);

}  // namespace shutterline::engine
