#include "worker/engine/accel/bvh.h"

#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <new>
#include <stdexcept>
#include <utility>

#include "common/base/work_limit.h"
#include "worker/engine/accel/bounds_tree.h"
#include "worker/engine/accel/facing.h"
#include "worker/engine/accel/swept_bounds.h"
#include "worker/engine/accel/triangle_refs.h"
#include "worker/engine/accel/view_scale.h"

namespace shutterline::engine {
namespace {

/// The tree is built in view space, where scenes are split well, but asked in the raster, where a tile and
/// what a triangle sweeps are rectangles. A triangle is collected if those of one of its references overlap
/// the tile's: what a node decides for all of its references is what each would decide alone. So the answer
/// does not depend on the tree.
class FlatBvh : public Bvh {
 public:
  explicit FlatBvh(std::shared_ptr<const FrameScene> frame) : frame_(std::move(frame)) {}

  /// As often as it can be in parallel, on up to `threads` threads.
  void BuildTree(int threads) {
    // More threads than processors would only make TBB complain.
    tbb::task_arena arena(std::clamp(threads, 1, tbb::info::default_concurrency()));
    const WorkLimit* const limit = WorkLimit::Current();
    arena.execute([&] {
      const WorkLimitScope scope(limit);
      BuildTreeInArena();
    });
  }

  void CollectVisible(const TileRect& rect, std::vector<uint32_t>& triangles) const override {
    if (nodes_.empty()) return;
    const TileBorders tile(rect);
    thread_local std::vector<uint32_t> cut;  // Triangles of several references, which may come again.
    cut.clear();
    const uint32_t end = uint32_t(nodes_.size()) - 1;  // The last node is a sentinel.
    for (uint32_t n = 0; n < end;) {
      const Node& node = nodes_[n];
      if (!tile.Overlap(node.bounds)) {
        n = node.skip;
        continue;
      }
      const bool whole = tile.Hold(node.bounds);
      const bool is_leaf = node.skip == n + 1;
      if (!whole && !is_leaf) {
        ++n;
        continue;
      }
      for (uint32_t i = node.first_ref; i < nodes_[node.skip].first_ref; ++i) {
        if (!whole && !tile.Overlap(bounds_[i])) continue;
        (refs_[i].spans == 1 ? triangles : cut).push_back(refs_[i].triangle);
      }
      n = node.skip;
    }
    std::sort(cut.begin(), cut.end());
    triangles.insert(triangles.end(), cut.begin(), std::unique(cut.begin(), cut.end()));
  }

 private:
  struct Node {
    SweptBounds bounds;  ///< Of its references.
    uint32_t skip;       ///< The next node that is not below this one.
    uint32_t first_ref;  ///< Its references end where those of node `skip` begin.
  };

  void BuildTreeInArena() {
    const BoundedRefs bounded = MakeBoundedRefs(*frame_, ViewScale(*frame_));
    const BoundsTree tree = BuildBoundsTree(bounded.bounds);
    if (tree.nodes.empty()) return;
    nodes_.reserve(tree.nodes.size());
    for (const BoundsNode& node : tree.nodes) nodes_.push_back({{}, node.skip, node.first_ref});
    refs_.reserve(tree.order.size());
    for (const uint32_t number : tree.order) refs_.push_back(bounded.refs[number]);
    BoundInRaster();
  }

  /// Bounds references and nodes in the raster, and drops the references that are never visible.
  void BoundInRaster() {
    const WorkLimit* const limit = WorkLimit::Current();
    bounds_.resize(refs_.size());
    const double far_depth = frame_->view.FarDepth();
    tbb::parallel_for(tbb::blocked_range<size_t>(0, refs_.size(), 1024),
                      [&](const tbb::blocked_range<size_t>& part) {
                        CheckWork(limit);
                        std::vector<RasterPoint> hull;
                        for (size_t i = part.begin(); i < part.end(); ++i) {
                          if (IsCulled(refs_[i].triangle)) continue;
                          hull.clear();
                          AppendHull(*frame_, refs_[i], hull);
                          bounds_[i] = BoundsInRaster(hull, far_depth);
                        }
                      });
    uint32_t ref = 0, kept = 0;
    for (Node& node : nodes_) {
      for (; ref < node.first_ref; ++ref) {
        if (bounds_[ref].IsEmpty()) continue;
        refs_[kept] = refs_[ref];
        bounds_[kept++] = bounds_[ref];
      }
      node.first_ref = kept;
    }
    refs_.resize(kept);
    bounds_.resize(kept);
    // Children come after their parents.
    for (size_t n = nodes_.size() - 1; n-- > 0;) {
      Node& node = nodes_[n];
      if (node.skip == n + 1) {
        for (uint32_t i = node.first_ref; i < nodes_[node.skip].first_ref; ++i) {
          node.bounds.Extend(bounds_[i]);
        }
      }
      for (uint32_t child = uint32_t(n) + 1; child < node.skip; child = nodes_[child].skip) {
        node.bounds.Extend(nodes_[child].bounds);
      }
    }
  }

  /// Seen from behind all through the shutter, and not drawn there.
  bool IsCulled(uint32_t number) const {
    const FrameTriangle& triangle = frame_->triangles[number];
    const FramePrimitive& primitive = frame_->primitives[triangle.primitive];
    if (primitive.material->double_sided) return false;
    std::array<const RasterPoint*, 3> points;
    for (size_t k = 0; k < 3; ++k) points[k] = frame_->ControlPoints(primitive, triangle.vertices[k]);
    return ShowsItsBackAlways(points, primitive.degree, primitive.pieces);
  }

  std::shared_ptr<const FrameScene> frame_;
  std::vector<Node> nodes_;
  std::vector<TriangleRef> refs_;
  std::vector<SweptBounds> bounds_;  ///< One a reference.
};

}  // namespace

absl::StatusOr<std::unique_ptr<const Bvh>> Bvh::Build(std::shared_ptr<const FrameScene> frame, int threads) {
  auto bvh = std::make_unique<FlatBvh>(std::move(frame));
  try {
    bvh->BuildTree(threads);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("build BVH: out of memory");
  } catch (const std::length_error&) {
    return absl::ResourceExhaustedError("build BVH: out of memory");
  }
  return std::unique_ptr<const Bvh>(std::move(bvh));
}

}  // namespace shutterline::engine
