#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/accel/view_bounds.h"

namespace shutterline::engine {

/// A node of a BoundsTree.
struct BoundsNode {
  ViewBounds bounds;   ///< Of all that is below it.
  uint32_t skip;       ///< The next node that is not below this one: its own number + 1 for a leaf.
  uint32_t first_ref;  ///< What is below it ends in `order` where that of node `skip` begins.
};

/// A binary tree over boxes. Nodes are in preorder, so a node's first child follows it, what is below any
/// node is one range of `order`, and a walk needs no stack.
struct BoundsTree {
  std::vector<BoundsNode> nodes;  ///< The last one is a sentinel. Empty without boxes.
  std::vector<uint32_t> order;    ///< Numbers of the boxes.
};

/// Cuts sets of boxes in the middle of their centres, along the axis on which these lie farthest apart, until
/// few are left. Not by surface area [wald2014]: a frame asks its tree less than a thousand times, so
/// building is dearer than asking. Runs in parallel in the calling thread's arena; the tree is a function of
/// the boxes and their order alone. Boxes must hold no NaN.
BoundsTree BuildBoundsTree(std::span<const ViewBounds> boxes);

}  // namespace shutterline::engine
