#pragma once

#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Tangents for MeshPrimitive::tangents from texture coordinate set `texcoord`, which the primitive must
/// have.
///
/// They agree with those of MikkTSpace [mikkelsen2008], for which normal maps are made: at each corner, the
/// directions of growing u of all triangles that have this position, normal and coordinate there, by value
/// and not by index, and the same orientation in the texture, are projected to the normal's plane and
/// averaged, weighted by the triangles' angles there. Triangles whose coordinates span no area take what
/// their neighbours have, or else any direction.
///
/// What differs: MikkTSpace averages over triangles that share edges, and keeps those apart that touch in a
/// vertex only; and its v points upwards, so that its signs are the opposite of glTF's.
///
/// Without normals, glTF's are those of the triangles, and each triangle is by itself.
///
/// The coordinates are those of the vertices: KHR_texture_transform does not enter. glTF asks for the texture
/// coordinates that belong to the normal texture, and tangents in a file know nothing of materials either.
std::vector<V4f> MakeTangents(const MeshPrimitive& primitive, int texcoord);

}  // namespace shutterline::engine
