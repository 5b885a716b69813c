#pragma once

#include "tests/scenes/glb_scene.h"

/// Light that is put into vertex colours, so that unlit scenes have form.
namespace shutterline::scenes {

/// What a matt surface of linear `color` and unit `normal` sends to every side under a sky, a sun from the
/// upper left in front, and light from the ground. Between 0.12 and 1 times `color`.
V3f BakedColor(const V3f& color, const V3f& normal);

/// Turns a primitive's normals into vertex colours of BakedColor; the normals go.
void BakeLight(Primitive& primitive, const V3f& color);

}  // namespace shutterline::scenes
