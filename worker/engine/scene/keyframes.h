#pragma once

#include <span>

#include "common/math/spaces.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// The value of `channel` at `time` (seconds), as glTF 2.0 (3.11 and appendix C) defines STEP, LINEAR and
/// CUBICSPLINE; before the first and after the last key the value of that key. `value` has room for
/// `channel.width` numbers. Rotations (x, y, z, w) come out as unit quaternions: LINEAR turns along the
/// shorter arc with constant speed, CUBICSPLINE normalises the interpolated components. All arithmetic is
/// in double precision; exactly at a key the key's own value comes out.
void SampleChannel(const AnimationChannel& channel, double time, std::span<double> value);

/// The unit quaternion of (x, y, z, w); the identity where its length is zero or not finite.
Quatd UnitQuaternion(double x, double y, double z, double w);

}  // namespace shutterline::engine
