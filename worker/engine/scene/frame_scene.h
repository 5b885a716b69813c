#pragma once

#include <absl/status/statusor.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/job/render_settings.h"
#include "common/math/bezier.h"
#include "common/math/spaces.h"
#include "worker/engine/scene/frame_light.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// The camera of a frame: a constant map between view space and homogeneous raster space. The camera's
/// *motion* is not here but in the vertices: they are given relative to the moving camera.
struct FrameView {
  bool perspective = true;
  int width = 0, height = 0;  ///< Pixels.
  /// x_raster = scale_x * x_view + center_x * w, y_raster = -scale_y * y_view + center_y * w, with
  /// w = -z_view (perspective) or 1 (orthographic).
  double scale_x = 1, scale_y = 1;
  double center_x = 0, center_y = 0;
  double znear = 0.1;  ///< Metres, > 0 for perspective.
  double zfar = 0;     ///< 0: infinite.
  /// The world's x, y and z axes as unit vectors in view space, at mid-shutter: a direction d in view space
  /// points to (d·x, d·y, d·z) in the world.
  std::array<V3d, 3> world_axes{V3d(1, 0, 0), V3d(0, 1, 0), V3d(0, 0, 1)};

  /// Where the camera is in the world at mid-shutter, metres.
  V3d world_position{0, 0, 0};

  /// Of a direction.
  V3d WorldFromView(const V3d& direction) const {
    return {direction.dot(world_axes[0]), direction.dot(world_axes[1]), direction.dot(world_axes[2])};
  }

  RasterPoint RasterFromView(const V3d& p) const {
    const double w = perspective ? -p.z : 1;
    // Orthographic depth is 1 at the near plane and 0 at the far plane.
    const double z = perspective ? znear : (zfar + p.z) / (zfar - znear);
    return {scale_x * p.x + center_x * w, -scale_y * p.y + center_y * w, z, w};
  }
  V3d ViewFromRaster(const RasterPoint& p) const {
    if (perspective) return {(p.x - center_x * p.w) / scale_x, (center_y * p.w - p.y) / scale_y, -p.w};
    return {(p.x / p.w - center_x) / scale_x, (center_y - p.y / p.w) / scale_y,
            p.z / p.w * (zfar - znear) - zfar};
  }
  /// Depth (z/w) at the far plane: what is smaller is clipped. 0 for an infinite far plane.
  double FarDepth() const;
};

/// Largest magnitude of a control point's coordinate: a product of six of them, relative to any tile's
/// corner, is still finite (an edge's crossing multiplies two, each of two clips doubles that and adds two).
inline constexpr double kMaxCoordinate = 1e44;

/// The smallest near distance: raster positions, coordinates over w >= znear, and their products are finite.
inline constexpr double kLeastNear = 1e-100;

static_assert(kMaxMotionDegree == kMaxBezierDegree);
inline constexpr int kMaxLinearPieces = 128;

/// A mesh primitive placed by a node, in this frame.
struct FramePrimitive {
  const MeshPrimitive* source = nullptr;  ///< Texture coordinates, colours; owned by the Scene.
  const Material* material = nullptr;
  int node = -1;
  uint32_t first_triangle = 0, triangle_count = 0;  ///< In FrameScene::triangles.
  uint32_t first_vertex = 0, vertex_count = 0;      ///< Vertices are numbered through all primitives.
  /// Degree of motion, 0 to kMaxMotionDegree, and the number of equal pieces of the shutter, a power of two
  /// up to kMaxMotionPieces (1 where the degree is 0), on each of which the motion is one Bezier curve.
  /// Vertex v's control points are PointsPerVertex() in a row, from
  /// control_points[first_control_point + (v - first_vertex) * PointsPerVertex()]. Piece s, over shutter
  /// time [s / pieces, (s + 1) / pieces], has points s * degree to s * degree + degree: the last point of a
  /// piece is the first of the next, so paths have no gaps. Primitives of one placed mesh that move have
  /// the same degree and pieces, so what they share stays shared.
  int degree = 0;
  int pieces = 1;
  uint64_t first_control_point = 0;
  /// The shutter cut into so many equal spans, a power of two and at least `pieces` (1 for degree 0 and
  /// where pieces are straight): on straight paths between their ends every vertex stays within
  /// kChordPixels (tolerance.h) of its curve. Not more than kMaxLinearPieces, whatever that leaves.
  int linear_pieces = 1;
  /// The node mirrors: triangles are counter-clockwise in raster space (y up) after their corners have
  /// been swapped at build; kept for reports.
  bool mirrored = false;
  /// The mesh has vertex colours and all of them are equal. Looked at for unlit materials only, else false.
  bool uniform_colors = false;
  /// Per-vertex unit normals in view space at mid-shutter, by the inverse transpose; none where the
  /// material is unlit or the mesh has none. normals[first_normal + (v - first_vertex)].
  bool has_normals = false;
  uint64_t first_normal = 0;
  /// Unit tangents in view space at mid-shutter, with the bitangent's sign in w: the bitangent is w times
  /// cross(normal, tangent), in the frame's own handedness (mirrored primitives have theirs turned round).
  /// Those of corner k of triangle T are tangents[first_tangent + 3 * (T - first_triangle) + k]. Only where
  /// the material is lit and has a normal texture that the mesh has coordinates for. Zero where there is no
  /// direction, and not exactly perpendicular to the normal: skins and uneven scales tilt them.
  bool has_tangents = false;
  uint64_t first_tangent = 0;
  /// Largest path length of a vertex over the shutter, pixels; infinity if one is behind the near plane at
  /// some instant that was looked at. 0 for degree 0, wherever the vertices are.
  double motion_pixels = 0;

  int PointsPerVertex() const { return pieces * degree + 1; }
  CurvePosition PositionAt(double t) const { return CurvePositionAt(pieces, t); }
};

struct FrameTriangle {
  std::array<uint32_t, 3> vertices;  ///< Global numbers. Seen from the front: counter-clockwise, y up.
  uint32_t primitive;
};

/// Everything that visibility needs of one frame: triangles whose vertices move on Bezier curves in
/// homogeneous raster space over the shutter. Object, skin, morph and camera motion are all in the
/// control points. Immutable; any number of threads may read it.
struct FrameScene {
  std::shared_ptr<const Scene> scene;
  FrameView view;
  std::vector<FramePrimitive> primitives;
  std::vector<FrameTriangle> triangles;
  std::vector<RasterPoint> control_points;
  std::vector<V3f> normals;  ///< Zero where a vertex has no direction.
  std::vector<V4f> tangents;
  std::vector<FrameLight> lights;
  /// Mip pyramids of the scene's images, shared between its frames; see Pyramid.
  PyramidTable pyramids;
  /// For people: meshes whose motion misses their true path by more than the tolerance, dropped vertices.
  std::vector<std::string> warnings;
  /// With a control point that is not finite or so large (above kMaxCoordinate) that products of a few
  /// coordinates would overflow.
  int64_t dropped_triangles = 0;

  /// The pyramid of an image of the scene; null where no drawn material uses the image in that encoding.
  const MipPyramid* Pyramid(int image, TextureEncoding encoding) const {
    const auto& of_encoding = pyramids[size_t(encoding)];
    return image >= 0 && size_t(image) < of_encoding.size() ? of_encoding[size_t(image)].get() : nullptr;
  }

  const RasterPoint& ControlPoint(const FramePrimitive& primitive, uint32_t vertex, int i) const {
    return ControlPoints(primitive, vertex)[i];
  }
  /// The PointsPerVertex() control points of a vertex.
  const RasterPoint* ControlPoints(const FramePrimitive& primitive, uint32_t vertex) const {
    return &control_points[primitive.first_control_point +
                           uint64_t{vertex - primitive.first_vertex} * uint64_t(primitive.PointsPerVertex())];
  }
  /// A vertex at shutter time t in [0, 1]: exactly a piece's end point at its ends. Vertices of degree 0 and
  /// vertices at rest on a curve are returned bit for bit, whatever t.
  RasterPoint VertexAt(const FramePrimitive& primitive, uint32_t vertex, double t) const {
    const RasterPoint* points = ControlPoints(primitive, vertex);
    if (primitive.degree == 0) return *points;
    const CurvePosition at = primitive.PositionAt(t);
    return BezierPoint(points + at.piece * primitive.degree, primitive.degree, at.u);
  }
};

/// Poses the scene over the shutter of `frame` and projects it: nodes, skins and morph targets are
/// evaluated exactly at as many times as the motion needs, and at check times in between.
/// INVALID_ARGUMENT where `settings` names a camera or an animation that the scene does not have (the
/// message lists those that it has); RESOURCE_EXHAUSTED where instancing exceeds 2^32 - 2 triangles.
absl::StatusOr<std::shared_ptr<const FrameScene>> BuildFrameScene(std::shared_ptr<const Scene> scene,
                                                                  int frame, const RenderSettings& settings);

/// The checks of BuildFrameScene on names alone, without building anything.
absl::Status ValidateAgainstScene(const Scene& scene, const RenderSettings& settings);

}  // namespace shutterline::engine
