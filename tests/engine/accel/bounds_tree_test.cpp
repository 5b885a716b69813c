#include "worker/engine/accel/bounds_tree.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace shutterline::engine {
namespace {

ViewBounds Box(float x, float y, float z, float size) {
  return {{x, y, z}, {x + size, y + size, z + size}};
}

bool Contains(const ViewBounds& outer, const ViewBounds& inner) {
  for (size_t axis = 0; axis < 3; ++axis) {
    if (inner.lower[axis] < outer.lower[axis] || inner.upper[axis] > outer.upper[axis]) return false;
  }
  return true;
}

/// Every box has one place, nodes hold what is below them, and leaves are small.
void ExpectIsTree(const BoundsTree& tree, const std::vector<ViewBounds>& boxes) {
  std::vector<uint32_t> sorted = tree.order;
  std::sort(sorted.begin(), sorted.end());
  ASSERT_EQ(sorted.size(), boxes.size());
  for (uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
  ASSERT_FALSE(tree.nodes.empty());
  const uint32_t end = uint32_t(tree.nodes.size()) - 1;
  EXPECT_EQ(tree.nodes[0].skip, end);
  EXPECT_EQ(tree.nodes[end].first_ref, boxes.size());
  for (uint32_t n = 0; n < end; ++n) {
    const BoundsNode& node = tree.nodes[n];
    const uint32_t last_ref = tree.nodes[node.skip].first_ref;
    ASSERT_GT(node.skip, n);
    ASSERT_GT(last_ref, node.first_ref);
    for (uint32_t i = node.first_ref; i < last_ref; ++i) {
      ASSERT_TRUE(Contains(node.bounds, boxes[tree.order[i]]));
    }
    if (node.skip == n + 1) {
      EXPECT_LE(last_ref - node.first_ref, 8u);
      continue;
    }
    const uint32_t right = tree.nodes[n + 1].skip;
    EXPECT_EQ(tree.nodes[n + 1].first_ref, node.first_ref);
    EXPECT_EQ(tree.nodes[right].skip, node.skip);
  }
}

std::vector<ViewBounds> RandomBoxes(size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<ViewBounds> boxes;
  for (size_t i = 0; i < count; ++i) {
    boxes.push_back(
        Box(100 * unit(random), 30 * unit(random), -unit(random), std::pow(10.0f, 3 * unit(random) - 3)));
  }
  return boxes;
}

TEST(BoundsTree, HoldsEveryBoxOnce) {
  EXPECT_TRUE(BuildBoundsTree({}).nodes.empty());
  for (const size_t count : {1, 2, 8, 9, 100, 3001, 40000}) {
    SCOPED_TRACE(testing::Message() << count << " boxes, seed " << count);
    const std::vector<ViewBounds> boxes = RandomBoxes(count, unsigned(count));
    ExpectIsTree(BuildBoundsTree(boxes), boxes);
  }
}

TEST(BoundsTree, CutsWhatNoPlaneCuts) {
  const std::vector<ViewBounds> equal(1000, Box(1, 2, 3, 1));
  ExpectIsTree(BuildBoundsTree(equal), equal);
  // The largest floats that bounds have, and differences that halving makes vanish.
  std::vector<ViewBounds> extreme;
  for (int i = 0; i < 100; ++i) {
    extreme.push_back(Box(i % 2 ? 0x1p60f : -0x1p60f, float(i) * 1e-45f, 0, 0));
    extreme.push_back(Box(std::ldexp(1.0f, i - 130), 0, std::ldexp(-1.0f, i - 140), 0));
  }
  ExpectIsTree(BuildBoundsTree(extreme), extreme);
}

TEST(BoundsTree, IsTheSameOnAnyNumberOfThreads) {
  const std::vector<ViewBounds> boxes = RandomBoxes(50000, 11);
  const auto build = [&](int threads) {
    return tbb::task_arena(threads).execute([&] { return BuildBoundsTree(boxes); });
  };
  const BoundsTree one = build(1), four = build(4);
  EXPECT_EQ(one.order, four.order);
  ASSERT_EQ(one.nodes.size(), four.nodes.size());
  for (size_t n = 0; n < one.nodes.size(); ++n) {
    EXPECT_EQ(one.nodes[n].skip, four.nodes[n].skip);
    EXPECT_EQ(one.nodes[n].bounds.lower, four.nodes[n].bounds.lower);
    EXPECT_EQ(one.nodes[n].bounds.upper, four.nodes[n].bounds.upper);
  }
}

}  // namespace
}  // namespace shutterline::engine
