#include "tests/support/frame_scene_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/check.h"
#include "worker/engine/scene/motion.h"

namespace shutterline::engine {
namespace {

template <typename Point, size_t N>
std::vector<RasterPoint> AllRaster(const FrameSceneBuilder& builder, const std::array<Point, N>& points) {
  std::vector<RasterPoint> result;
  for (const Point& point : points) result.push_back(builder.Raster(point));
  return result;
}

template <size_t N>
std::vector<RasterPoint> ToVector(const std::array<RasterPoint, N>& points) {
  return {points.begin(), points.end()};
}

const std::vector<std::array<uint32_t, 3>> kOneTriangle{{0, 1, 2}};
const std::vector<std::array<uint32_t, 3>> kTwoTriangles{{0, 1, 2}, {0, 2, 3}};

}  // namespace

FrameView PerspectiveView(int width, int height, double yfov_radians, double znear, double zfar) {
  FrameView view;
  view.perspective = true;
  view.width = width;
  view.height = height;
  view.scale_x = view.scale_y = height / 2.0 / std::tan(yfov_radians / 2);
  view.center_x = width / 2.0;
  view.center_y = height / 2.0;
  view.znear = znear;
  view.zfar = zfar;
  return view;
}

FrameView OrthographicView(int width, int height, double ymag, double znear, double zfar) {
  FrameView view;
  view.perspective = false;
  view.width = width;
  view.height = height;
  view.scale_x = view.scale_y = height / (2 * ymag);
  view.center_x = width / 2.0;
  view.center_y = height / 2.0;
  view.znear = znear;
  view.zfar = zfar;
  return view;
}

RasterPoint FrameSceneBuilder::Raster(const V3d& view_point) const {
  return view_.RasterFromView(view_point);
}

RasterPoint FrameSceneBuilder::Raster(const Corner& corner) const {
  // Only the depth is taken from the camera's map: x and y are then exactly what the test asked for.
  const RasterPoint on_axis = view_.RasterFromView(V3d(0, 0, -corner.distance));
  return {corner.x * on_axis.w, corner.y * on_axis.w, on_axis.z, on_axis.w};
}

int FrameSceneBuilder::AddMesh(std::vector<RasterPoint> open, std::vector<RasterPoint> close,
                               const std::vector<std::array<uint32_t, 3>>& triangles, const FlatLook& look) {
  SL_CHECK(close.empty() || close.size() == open.size());
  SL_CHECK(look.vertex_colors.empty() || look.vertex_colors.size() == open.size());
  for (const auto& triangle : triangles) {
    for (const uint32_t vertex : triangle) SL_CHECK(vertex < open.size());
  }
  if (close.empty()) {
    parts_.push_back({std::move(open), 0, 1, triangles, look});
    return int(parts_.size()) - 1;
  }
  std::vector<RasterPoint> ends;
  for (size_t v = 0; v < open.size(); ++v) ends.insert(ends.end(), {open[v], close[v]});
  parts_.push_back({std::move(ends), 1, 1, triangles, look});
  return int(parts_.size()) - 1;
}

int FrameSceneBuilder::AddCurvedMesh(std::vector<RasterPoint> control_points, int degree, int pieces,
                                     const std::vector<std::array<uint32_t, 3>>& triangles,
                                     const FlatLook& look) {
  SL_CHECK(control_points.size() % size_t(degree * pieces + 1) == 0);
  parts_.push_back({std::move(control_points), degree, pieces, triangles, look});
  return int(parts_.size()) - 1;
}

int FrameSceneBuilder::AddViewMesh(const std::vector<V3d>& open, const std::vector<V3d>& close,
                                   const std::vector<std::array<uint32_t, 3>>& triangles,
                                   const FlatLook& look) {
  std::vector<RasterPoint> raster_open, raster_close;
  for (const V3d& point : open) raster_open.push_back(Raster(point));
  for (const V3d& point : close) raster_close.push_back(Raster(point));
  return AddMesh(std::move(raster_open), std::move(raster_close), triangles, look);
}

int FrameSceneBuilder::AddRasterTriangle(const std::array<RasterPoint, 3>& vertices, const FlatLook& look) {
  return AddMesh(ToVector(vertices), {}, kOneTriangle, look);
}
int FrameSceneBuilder::AddRasterTriangle(const std::array<RasterPoint, 3>& open,
                                         const std::array<RasterPoint, 3>& close, const FlatLook& look) {
  return AddMesh(ToVector(open), ToVector(close), kOneTriangle, look);
}
int FrameSceneBuilder::AddTriangle(const std::array<Corner, 3>& vertices, const FlatLook& look) {
  return AddMesh(AllRaster(*this, vertices), {}, kOneTriangle, look);
}
int FrameSceneBuilder::AddTriangle(const std::array<Corner, 3>& open, const std::array<Corner, 3>& close,
                                   const FlatLook& look) {
  return AddMesh(AllRaster(*this, open), AllRaster(*this, close), kOneTriangle, look);
}
int FrameSceneBuilder::AddViewTriangle(const std::array<V3d, 3>& vertices, const FlatLook& look) {
  return AddMesh(AllRaster(*this, vertices), {}, kOneTriangle, look);
}
int FrameSceneBuilder::AddViewTriangle(const std::array<V3d, 3>& open, const std::array<V3d, 3>& close,
                                       const FlatLook& look) {
  return AddMesh(AllRaster(*this, open), AllRaster(*this, close), kOneTriangle, look);
}

int FrameSceneBuilder::AddQuad(const std::array<Corner, 4>& vertices, const FlatLook& look) {
  return AddMesh(AllRaster(*this, vertices), {}, kTwoTriangles, look);
}
int FrameSceneBuilder::AddQuad(const std::array<Corner, 4>& open, const std::array<Corner, 4>& close,
                               const FlatLook& look) {
  return AddMesh(AllRaster(*this, open), AllRaster(*this, close), kTwoTriangles, look);
}

int FrameSceneBuilder::AddRectangle(double x0, double y0, double x1, double y1, double distance,
                                    const FlatLook& look, double dx, double dy) {
  // Raster y points down, so this order is counter-clockwise as one looks at the picture.
  const std::array<Corner, 4> open{
      {{x0, y0, distance}, {x0, y1, distance}, {x1, y1, distance}, {x1, y0, distance}}};
  if (dx == 0 && dy == 0) return AddQuad(open, look);
  std::array<Corner, 4> close = open;
  for (Corner& corner : close) {
    corner.x += dx;
    corner.y += dy;
  }
  return AddQuad(open, close, look);
}

std::shared_ptr<const FrameScene> FrameSceneBuilder::Build() const {
  auto scene = std::make_shared<Scene>();
  scene->name = "built by a test";
  auto frame = std::make_shared<FrameScene>();
  frame->view = view_;

  // Materials and meshes first: the frame's primitives point into them.
  for (size_t p = 0; p < parts_.size(); ++p) {
    const Part& part = parts_[p];
    Material material;
    material.base_color_factor =
        V4f(part.look.color.x, part.look.color.y, part.look.color.z, part.look.alpha);
    material.alpha_mode = part.look.alpha_mode;
    material.alpha_cutoff = part.look.alpha_cutoff;
    material.unlit = true;
    material.double_sided = part.look.double_sided;
    scene->materials.push_back(material);
    MeshPrimitive source;
    source.positions.resize(part.VertexCount());
    source.colors = part.look.vertex_colors;
    source.triangles = part.triangles;
    source.material = int(p);
    Mesh mesh;
    mesh.primitives.push_back(std::move(source));
    scene->meshes.push_back(std::move(mesh));
    Node node;
    node.mesh = int(p);
    scene->nodes.push_back(node);
    scene->roots.push_back(int(p));
  }
  scene->materials.emplace_back();  // glTF's default material, always the last.

  uint32_t vertex_count = 0;
  for (size_t p = 0; p < parts_.size(); ++p) {
    const Part& part = parts_[p];
    FramePrimitive primitive;
    primitive.source = &scene->meshes[p].primitives[0];
    primitive.material = &scene->materials[p];
    primitive.node = int(p);
    primitive.first_triangle = uint32_t(frame->triangles.size());
    primitive.triangle_count = uint32_t(part.triangles.size());
    primitive.first_vertex = vertex_count;
    primitive.vertex_count = uint32_t(part.VertexCount());
    primitive.degree = part.degree;
    primitive.pieces = part.pieces;
    primitive.uniform_colors = std::ranges::all_of(
        part.look.vertex_colors, [&](const V4f& c) { return c == part.look.vertex_colors[0]; });
    primitive.first_control_point = frame->control_points.size();
    frame->control_points.insert(frame->control_points.end(), part.control_points.begin(),
                                 part.control_points.end());
    const ControlPointFacts facts =
        FactsOf(view_, *primitive.source, part.degree, part.pieces, part.control_points);
    primitive.motion_pixels = facts.motion_pixels;
    primitive.linear_pieces = LinearPiecesFor(part.degree, part.pieces, facts.chord_pixels);
    for (const auto& t : part.triangles) {
      frame->triangles.push_back(
          {{vertex_count + t[0], vertex_count + t[1], vertex_count + t[2]}, uint32_t(p)});
    }
    vertex_count += primitive.vertex_count;
    frame->primitives.push_back(primitive);
  }
  frame->scene = std::move(scene);
  return frame;
}

}  // namespace shutterline::engine
