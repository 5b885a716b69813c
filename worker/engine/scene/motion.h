#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/mesh_pose.h"

/// The steps of fitting Bezier motion to a primitive. All run in parallel over vertices, and no result
/// depends on how the work was split.
namespace shutterline::engine {

/// What the control points of a primitive turned out to be.
struct ControlPointFacts {
  bool all_usable = true;    ///< See IsUsable.
  double motion_pixels = 0;  ///< See FramePrimitive.
  /// Of single chords of the pieces, depth counted so that kPathDepth is kChordPixels; see LinearPiecesFor.
  double chord_pixels = 0;
};

/// Finite, and not so large that products of a few coordinates overflow (kMaxCoordinate).
bool IsUsable(const RasterPoint& p);

/// Beyond the near plane, where a raster position means something.
bool IsInFront(const RasterPoint& p);

/// The control points of the curve of degree points.size() - 1 that passes through `points` at equal
/// intervals of u. `points` are its values at u = 0, 1/n, ..., 1; the first and the last stay as they are, a
/// point at rest stays where it is bit for bit, and reversed points give reversed control points bit for
/// bit.
void InterpolateBezier(std::span<RasterPoint> points);

/// Writes where `pose` has `count` vertices, from number `first` on, to every `stride`th of `points`.
void WritePlaces(const FrameView& view, const MeshPrimitive& primitive, const MeshPose& pose, uint32_t first,
                 uint32_t count, size_t stride, RasterPoint* points);

/// Whether a vertex is not at one place in both poses. Vertices that are not usable do not count.
bool AnyVertexMoves(const FrameView& view, const MeshPrimitive& primitive, const MeshPose& a,
                    const MeshPose& b);

/// Writes the control points of all vertices of a primitive, whose curves pass through the places that the
/// poses at pieces * degree + 1 equal intervals of the shutter have. Returns the facts of FactsOf.
ControlPointFacts WriteCurves(const FrameView& view, const MeshPrimitive& primitive,
                              std::span<const uint8_t> used, std::span<const MeshPose* const> poses,
                              int degree, int pieces, std::span<RasterPoint> points);

/// Facts of the control points of all vertices of a primitive.
ControlPointFacts FactsOf(const FrameView& view, const MeshPrimitive& primitive, int degree, int pieces,
                          std::span<const RasterPoint> control_points);

/// See FramePrimitive::linear_pieces; `chord_pixels` is that of ControlPointFacts.
int LinearPiecesFor(int degree, int pieces, double chord_pixels);

/// How far a representation leaves the true path: pixels, and depth as a fraction (kPathDepth).
struct PathError {
  double pixels = 0, depth = 0;

  bool IsWithinTolerance() const;
  /// In multiples of the tolerance.
  double Excess() const;
  /// Takes the larger of both, each by itself.
  void Extend(const PathError& other);
};

/// The distance of `fit` from `path`, two places of a vertex at one time, as far as the frame can show it.
/// In front of the near plane: of the raster positions and of the depths; a vertex outside of the frame
/// shows by the edges that lead there, so its distance counts the less the farther out it is. Behind the near
/// plane there is no raster position: the angle at the eye counts. Places that are not usable count nothing.
PathError PathErrorBetween(const FrameView& view, const RasterPoint& path, const RasterPoint& fit);

/// True only where PathErrorBetween is within tolerance; seen without dividing. False says nothing.
bool IsSurelyWithinTolerance(const FrameView& view, const RasterPoint& path, const RasterPoint& fit);

}  // namespace shutterline::engine
