#include "worker/engine/accel/bounds_tree.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <limits>

#include "common/base/work_limit.h"

namespace shutterline::engine {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr ViewBounds kNothing{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
constexpr uint32_t kLeafBoxes = 8;
/// Sets of so many boxes are cut by tasks of their own.
constexpr uint32_t kTaskBoxes = 8192;

/// A box to be sorted: its centre, times two.
struct Item {
  std::array<float, 3> centre;
  uint32_t box;
};

void Extend(ViewBounds& bounds, const ViewBounds& other) {
  for (size_t axis = 0; axis < 3; ++axis) {
    bounds.lower[axis] = std::min(bounds.lower[axis], other.lower[axis]);
    bounds.upper[axis] = std::max(bounds.upper[axis], other.upper[axis]);
  }
}

class Builder {
 public:
  Builder(std::span<const ViewBounds> boxes, BoundsTree& tree)
      : boxes_(boxes), items_(boxes.size()), order_(tree.order) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, boxes.size(), kTaskBoxes),
                      [&](const tbb::blocked_range<size_t>& part) {
                        for (size_t i = part.begin(); i < part.end(); ++i) {
                          items_[i].box = uint32_t(i);
                          for (size_t axis = 0; axis < 3; ++axis) {
                            items_[i].centre[axis] = boxes[i].lower[axis] + boxes[i].upper[axis];
                          }
                        }
                      });
  }

  /// Appends the tree of items [begin, end) to `nodes`, where `skip` counts from the beginning of `nodes`.
  /// Returns its bounds. As deep a recursion as the tree: each cut halves an extent, or else the set, so the
  /// digits and exponents of three floats bound it.
  ViewBounds Build(uint32_t begin, uint32_t end, std::vector<BoundsNode>& nodes) {
    const size_t n = nodes.size();
    nodes.push_back({kNothing, 0, begin});
    ViewBounds bounds = kNothing;
    if (end - begin <= kLeafBoxes) {
      for (uint32_t i = begin; i < end; ++i) {
        order_[i] = items_[i].box;
        Extend(bounds, boxes_[items_[i].box]);
      }
    } else if (const uint32_t middle = CheckedCut(begin, end); end - begin < kTaskBoxes) {
      bounds = Build(begin, middle, nodes);
      Extend(bounds, Build(middle, end, nodes));
    } else {
      std::vector<BoundsNode> left, right;
      ViewBounds right_bounds;
      tbb::parallel_invoke([&] { bounds = Build(begin, middle, left); },
                           [&] { right_bounds = Build(middle, end, right); });
      Extend(bounds, right_bounds);
      for (const std::vector<BoundsNode>* part : {&left, &right}) {
        const uint32_t offset = uint32_t(nodes.size());
        for (BoundsNode node : *part) {
          node.skip += offset;
          nodes.push_back(node);
        }
      }
    }
    nodes[n].bounds = bounds;
    nodes[n].skip = uint32_t(nodes.size());
    return bounds;
  }

 private:
  /// Cut, unless the work's time is over. A hostile set is cut a few items at a time.
  uint32_t CheckedCut(uint32_t begin, uint32_t end) {
    if (end - begin >= kTaskBoxes) CheckWork(limit_);
    return Cut(begin, end);
  }

  /// Sorts items [begin, end) into two sets that are not empty; returns where the second begins.
  uint32_t Cut(uint32_t begin, uint32_t end) {
    std::array<float, 3> low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
    for (uint32_t i = begin; i < end; ++i) {
      for (size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], items_[i].centre[axis]);
        high[axis] = std::max(high[axis], items_[i].centre[axis]);
      }
    }
    size_t longest = 0;
    for (size_t axis = 1; axis < 3; ++axis) {
      if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
    }
    const float border = 0.5f * low[longest] + 0.5f * high[longest];
    Item* const first = items_.data() + begin;
    Item* const last = items_.data() + end;
    Item* const cut =
        std::partition(first, last, [&](const Item& item) { return item.centre[longest] < border; });
    // Where all centres are as good as one, any halves will do.
    if (cut == first || cut == last) return begin + (end - begin) / 2;
    return begin + uint32_t(cut - first);
  }

  const WorkLimit* const limit_ = WorkLimit::Current();
  const std::span<const ViewBounds> boxes_;
  std::vector<Item> items_;
  std::vector<uint32_t>& order_;
};

}  // namespace

BoundsTree BuildBoundsTree(std::span<const ViewBounds> boxes) {
  BoundsTree tree;
  if (boxes.empty()) return tree;
  tree.order.resize(boxes.size());
  Builder(boxes, tree).Build(0, uint32_t(boxes.size()), tree.nodes);
  tree.nodes.push_back({kNothing, uint32_t(tree.nodes.size()), uint32_t(boxes.size())});
  return tree;
}

}  // namespace shutterline::engine
