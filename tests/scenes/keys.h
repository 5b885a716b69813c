#pragma once

#include <cmath>

#include "tests/scenes/glb_scene.h"

namespace shutterline::scenes {

/// What the speeds of generated scenes refer to: the defaults of the render settings.
inline constexpr double kFrameHeight = 768;              ///< Pixels.
inline constexpr double kFrameRate = 24;                 ///< Frames a second.
inline constexpr double kShutterSeconds = 0.5 / 24;      ///< Of the default shutter, 0 to 0.5 frames.
inline constexpr int kAnimatedFrames = 24;               ///< Keys reach from frame 0 to this one.
inline constexpr double kDefaultYfov = 40 * M_PI / 180;  ///< Radians.

/// Pixels that a metre covers at `depth` metres before the camera.
double PixelsPerMetre(double yfov, double depth);

/// Back and forth about `centre`, so that a scene stays in view however fast it is: one way for two
/// frames, then back for two. `per_shutter` is the way over the default shutter, which lies within one leg
/// in every frame. At frame 0 the node is at one end, about to move along +`per_shutter`.
Channel SwingTranslation(int node, const V3f& centre, const V3f& per_shutter);

/// The same for the weight of a morph target, between 0 and 1: its offsets are the way of one leg, which is
/// kLegShutters times that of the default shutter.
Channel SwingWeight(int node);
inline constexpr double kLegShutters = 4;

/// The same for a rotation: `base`, turned back and forth about `axis` (unit) of the parent's space by
/// `degrees_per_shutter` over the default shutter; below 45, so that a leg is less than half a turn.
Channel SwingRotation(int node, const V3f& axis, double degrees_per_shutter, const Imath::Quatf& base);

/// A rotation about `axis` (unit) at a constant rate, with keys at most 45 degrees apart, so that the
/// short way between two keys is the way meant.
Channel Spin(int node, const V3f& axis, double start_degrees, double degrees_per_shutter);

/// A node that holds camera 0 of `scene` (added here), at `eye`, looking at `target`, y up.
Node CameraNode(GlbScene& scene, const Camera& camera, const V3f& eye, const V3f& target);

/// A rotation by `degrees` about `axis` (unit).
Imath::Quatf Turn(const V3f& axis, double degrees);

}  // namespace shutterline::scenes
