#pragma once

#include <cstdint>
#include <string>

#include "common/job/render_settings.h"
#include "tests/fuzz/hostile_frames.h"

/// What must hold of every resolver whatever it is given. Each returns what is broken, or nothing.
namespace shutterline::engine {

/// Weights of each pixel add up to its total at most, positions lie on their triangles, colours are those of
/// convex combinations, all is finite; film and pairs hold the same coverage; the order of candidates and
/// what was resolved before do not show.
std::string BrokenResolution(const HostileFrame& input, const RenderSettings& settings, uint64_t seed);

/// The slice resolver gives the same bits on every instruction set.
std::string BrokenTargets(const HostileFrame& input, const RenderSettings& settings);

/// The slice resolver sees what the plain one sees, up to the rounding of ends of segments. For OnLattice.
std::string BrokenAgreement(const HostileFrame& input, const RenderSettings& settings);

/// Every pixel is covered completely, to the last subpixel. For Curtain.
std::string BrokenCurtain(const HostileFrame& input, const RenderSettings& settings);

/// MakeSegment: segments lie on their lines, their ends are in order, depths and positions are those of the
/// triangle.
std::string BrokenSegments(const HostileFrame& input, const RenderSettings& settings);

}  // namespace shutterline::engine
