#pragma once

#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// Embree computes in single precision, in which scenes of size 1e±18 overflow or vanish. View space is
/// therefore divided by this power of two, metres a unit: the largest coordinate of any vertex of any
/// triangle is then about 2^kViewScaleExponent. Dividing by a power of two rounds nothing. 1 where nothing
/// has a size.
double ViewScale(const FrameScene& frame);

/// Above 0, so that what is far smaller than the scene keeps away from denormal products; low enough that
/// the product of three coordinates stays far below the largest float.
inline constexpr int kViewScaleExponent = 20;

}  // namespace shutterline::engine
