#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// A perspective camera with square pixels and its axis through the middle of the frame.
FrameView PerspectiveView(int width, int height, double yfov_radians = 0.8, double znear = 0.1,
                          double zfar = 0);
/// An orthographic camera with square pixels, the frame `2 * ymag` metres high.
FrameView OrthographicView(int width, int height, double ymag = 1, double znear = 0.1, double zfar = 100);

/// A vertex as tests like to name it: where it appears, in pixels, and how far from the camera it is
/// along the view direction, in metres.
struct Corner {
  double x = 0, y = 0, distance = 1;
};

/// How the triangles of one primitive look: one unlit colour, times the colours of the vertices if there
/// are any (then shading varies over a triangle).
struct FlatLook {
  V3f color{1, 1, 1};
  bool double_sided = true;
  std::vector<V4f> vertex_colors = {};
  float alpha = 1;  ///< Times that of the vertices.
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;
};

/// Makes FrameScenes without a file: every Add call makes one primitive with its own unlit material and
/// returns its number. Triangles are numbered through all primitives in the order in which they are added.
/// Corners are taken in the order given: where `double_sided` is false, the front is the side from which
/// they run counter-clockwise as the picture is looked at.
class FrameSceneBuilder {
 public:
  explicit FrameSceneBuilder(const FrameView& view) : view_(view) {}

  /// Any mesh: `close` is empty (degree 0) or as long as `open` (degree 1). Everything else ends up here.
  int AddMesh(std::vector<RasterPoint> open, std::vector<RasterPoint> close,
              const std::vector<std::array<uint32_t, 3>>& triangles, const FlatLook& look = {});
  int AddViewMesh(const std::vector<V3d>& open, const std::vector<V3d>& close,
                  const std::vector<std::array<uint32_t, 3>>& triangles, const FlatLook& look = {});

  /// Any mesh on Bezier curves: pieces * degree + 1 control points a vertex, one vertex after the other.
  int AddCurvedMesh(std::vector<RasterPoint> control_points, int degree, int pieces,
                    const std::vector<std::array<uint32_t, 3>>& triangles, const FlatLook& look = {});

  int AddRasterTriangle(const std::array<RasterPoint, 3>& vertices, const FlatLook& look = {});
  int AddRasterTriangle(const std::array<RasterPoint, 3>& open, const std::array<RasterPoint, 3>& close,
                        const FlatLook& look = {});
  int AddTriangle(const std::array<Corner, 3>& vertices, const FlatLook& look = {});
  int AddTriangle(const std::array<Corner, 3>& open, const std::array<Corner, 3>& close,
                  const FlatLook& look = {});
  int AddViewTriangle(const std::array<V3d, 3>& vertices, const FlatLook& look = {});
  int AddViewTriangle(const std::array<V3d, 3>& open, const std::array<V3d, 3>& close,
                      const FlatLook& look = {});

  /// Two triangles that share the diagonal from corner 0 to corner 2: (0, 1, 2) and (0, 2, 3).
  int AddQuad(const std::array<Corner, 4>& vertices, const FlatLook& look = {});
  int AddQuad(const std::array<Corner, 4>& open, const std::array<Corner, 4>& close,
              const FlatLook& look = {});
  /// The rectangle [x0, x1] × [y0, y1] of raster space at one distance, front to the camera, which slides by
  /// (dx, dy) pixels over the shutter.
  int AddRectangle(double x0, double y0, double x1, double y1, double distance, const FlatLook& look = {},
                   double dx = 0, double dy = 0);

  /// The point in homogeneous raster space that `view` gives a corner or a point of view space.
  RasterPoint Raster(const Corner& corner) const;
  RasterPoint Raster(const V3d& view_point) const;

  /// The scene of what has been added so far. The builder may go on being used.
  std::shared_ptr<const FrameScene> Build() const;

 private:
  struct Part {
    std::vector<RasterPoint> control_points;
    int degree = 0, pieces = 1;
    std::vector<std::array<uint32_t, 3>> triangles;
    FlatLook look;

    size_t VertexCount() const { return control_points.size() / size_t(degree * pieces + 1); }
  };

  FrameView view_;
  std::vector<Part> parts_;
};

}  // namespace shutterline::engine
