#pragma once

#include <functional>

#include "tests/scenes/glb_scene.h"

/// Shapes, appended to a primitive with outward normals. Triangles are counter-clockwise seen from outside.
namespace shutterline::scenes {

/// A colour as people write it, 0xRRGGBB in sRGB, made linear.
V3f Srgb(uint32_t rgb);

/// A surface over u, v in [0, 1] in `columns` × `rows` cells of two triangles; the front is on the side of
/// ∂u × ∂v. Normals are those of the cells at each corner, averaged, unless `smooth` is false: then every
/// triangle has its own corners and its own normal.
void AddSurface(Primitive& primitive, int columns, int rows,
                const std::function<V3f(double u, double v)>& surface, bool smooth = true);

/// A flat polygon of three corners or more, in order, with its own corners and normal.
void AddPolygon(Primitive& primitive, const std::vector<V3f>& corners);

/// A box with corners `min` and `max`: 12 triangles.
void AddBox(Primitive& primitive, const V3f& min, const V3f& max);

/// A tapered tube of `sides` flat sides from `a` to `b`, open at both ends: 2 × sides triangles.
void AddTube(Primitive& primitive, const V3f& a, const V3f& b, float radius_a, float radius_b, int sides);

/// 2 × columns × rows triangles each; those at a sphere's poles have no area there.
void AddSphere(Primitive& primitive, const V3f& centre, float radius, int columns, int rows);
/// A ring about the z axis.
void AddTorus(Primitive& primitive, const V3f& centre, float ring_radius, float tube_radius, int columns,
              int rows);

/// The regular solids with `faces` 4, 6, 8 or 20 triangles or squares, corners at `radius`.
void AddRegularSolid(Primitive& primitive, int faces, float radius);

/// The unit vectors that complete `direction` (unit) to a right-handed frame: a × b = direction.
void FrameOf(const V3f& direction, V3f& a, V3f& b);

}  // namespace shutterline::scenes
