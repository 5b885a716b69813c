#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/accel/bounds_tree.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// Children of a node: what vectors look at together.
inline constexpr int kTreeWidth = 8;

/// How vertices move: as FramePrimitive has it. {0, 1} where nothing does.
struct MotionClass {
  int degree = 0, pieces = 1;

  int Points() const { return pieces * degree + 1; }
  friend bool operator==(const MotionClass&, const MotionClass&) = default;
};

/// Triangles that lie together and move by one class. A block is a row of numbers in OccluderTree::blocks:
/// this header, then the control points of its vertices in planes, x, y and z of each, `stride` numbers a
/// piece.
struct BlockHeader {
  static constexpr int kMostTriangles = 8, kMostVertices = 3 * kMostTriangles;

  std::array<uint32_t, kMostTriangles> masks{};                  ///< The corners of each, by bit.
  std::array<std::array<uint8_t, 3>, kMostTriangles> corners{};  ///< Numbers of vertices.
  uint8_t count = 0;                                             ///< Of triangles.
  uint8_t vertices = 0;
  uint8_t stride = 0;  ///< `vertices` made a multiple of four.
  uint8_t motion_class = 0;
  uint8_t is_last = 1;  ///< Of its leaf; else another follows it.
  std::array<uint8_t, 3> unused{};
};
/// In numbers.
inline constexpr int kHeaderSize = sizeof(BlockHeader) / sizeof(double);
static_assert(sizeof(BlockHeader) == 64);

/// A triangle's place in the tree.
struct OccluderPlace {
  uint32_t block = 0xffffffff;  ///< OccluderTree::blocks from 4 × this on.
  uint8_t number = 0;           ///< In its block.
};

/// Numbers of one node over one span of the shutter: for each axis the centres of its children's boxes, then
/// half their extents; where anything moves, then what each of these gains over the span. In single precision
/// relative to OccluderTree::centre, and widened by their roundings: a box holds its triangles at any
/// instant.
inline constexpr int kNodePlane = 6 * kTreeWidth;

/// A frame's triangles that may occlude, those of opaque materials, in a tree eight children wide that is
/// asked for one instant at a time. Boxes move with what they hold, straight over each of a few spans of the
/// shutter, so camera motion does not blow them up. All lengths are in view space divided by `scale`.
/// Immutable.
struct OccluderTree {
  double scale = 1;
  V3d centre{0, 0, 0};
  bool moves = false;        ///< Else nodes have no gains and there is one span.
  int spans = 1;             ///< A power of two.
  int node_count = 0;        ///< 0: there is nothing. Node 0 is the root.
  std::vector<float> nodes;  ///< Span by span, node by node.
  /// Of nodes; a leaf, whose first block is at 4 × b, is ~b; kNoChild: none.
  std::vector<std::array<int32_t, kTreeWidth>> children;
  std::vector<double> blocks;         ///< Begin at multiples of four; padded at the end for whole vectors.
  std::vector<OccluderPlace> places;  ///< By triangle of the frame.
  std::vector<MotionClass> classes;

  static constexpr int32_t kNoChild = INT32_MIN;

  /// With motion, or all as it is at mid-shutter. In the calling thread's arena; the tree does not depend on
  /// how.
  static OccluderTree Build(const FrameScene& frame, bool motion);

  const float* Node(int span, int32_t node) const {
    return nodes.data() +
           (size_t(span) * size_t(node_count) + size_t(node)) * size_t(moves ? 2 : 1) * kNodePlane;
  }
};

}  // namespace shutterline::engine
