#pragma once

#include <functional>

#include "tests/scenes/glb_scene.h"

/// Texture coordinates for shapes (shapes.h), in the order in which they were appended to a primitive: every
/// position gets its coordinates once.
namespace shutterline::scenes {

/// Of the latest AddSurface (smooth) of as many `columns` and `rows`: `map` of its u and v.
void MapSurface(Primitive& primitive, int columns, int rows,
                const std::function<V2f(double u, double v)>& map);

/// Of all positions that have none yet: their place, `per_metre` times, on the plane of axes that their
/// normal faces most, upright on walls and never mirrored. `turned`: by a quarter. For shapes each of whose
/// sides faces one way.
void MapByFacing(Primitive& primitive, float per_metre, const V2f& offset = V2f(0), bool turned = false);

/// Takes all texture coordinates away: for variants without textures.
void DropTexcoords(GlbScene& scene);

}  // namespace shutterline::scenes
