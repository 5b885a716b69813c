#include "worker/engine/accel/bvh.h"

#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <utility>

#include "worker/engine/accel/bounds_tree.h"
#include "worker/engine/accel/frustum_cull.h"
#include "worker/engine/accel/triangle_refs.h"
#include "worker/engine/accel/view_scale.h"

namespace shutterline::engine {
namespace {

/// A triangle is collected if, for one of its references, neither the bounds nor the hull lie outside: what
/// a node decides for all of its references is what each would decide alone. So the answer does not depend on
/// the tree.
class FlatBvh : public Bvh {
 public:
  explicit FlatBvh(std::shared_ptr<const FrameScene> frame) : frame_(std::move(frame)) {}

  /// As often as it can be in parallel, on up to `threads` threads.
  void BuildTree(int threads) {
    // More threads than processors would only make TBB complain.
    tbb::task_arena arena(std::clamp(threads, 1, tbb::info::default_concurrency()));
    arena.execute([&] {
      scale_ = ViewScale(*frame_);
      BuildTreeInArena();
    });
  }

  void CollectVisible(const TileRect& rect, std::vector<uint32_t>& triangles) const override {
    if (nodes_.empty()) return;
    const TileFrustum frustum(frame_->view, rect, scale_);
    thread_local std::vector<uint32_t> cut;  // Triangles of several references, which may come again.
    thread_local std::vector<RasterPoint> hull;
    cut.clear();
    const uint32_t end = uint32_t(nodes_.size()) - 1;  // The last node is a sentinel.
    for (uint32_t n = 0; n < end;) {
      const Node& node = nodes_[n];
      const TileFrustum::Side side = frustum.ClassifyBox(node.bounds);
      const bool is_leaf = node.skip == n + 1;
      if (side == TileFrustum::Side::kCrossing && !is_leaf) {
        ++n;
        continue;
      }
      if (side != TileFrustum::Side::kOutside) {
        for (uint32_t i = node.first_ref; i < nodes_[node.skip].first_ref; ++i) {
          const TriangleRef& ref = refs_[i];
          if (side == TileFrustum::Side::kCrossing) {
            if (frustum.ClassifyBox(bounds_[i]) == TileFrustum::Side::kOutside) continue;
            hull.clear();
            AppendHull(*frame_, ref, hull);
            if (!frustum.MayContain(hull)) continue;
          }
          (ref.spans == 1 ? triangles : cut).push_back(ref.triangle);
        }
      }
      n = node.skip;
    }
    std::sort(cut.begin(), cut.end());
    triangles.insert(triangles.end(), cut.begin(), std::unique(cut.begin(), cut.end()));
  }

 private:
  using Node = BoundsNode;

  void BuildTreeInArena() {
    BoundedRefs bounded = MakeBoundedRefs(*frame_, scale_);
    BoundsTree tree = BuildBoundsTree(bounded.bounds);
    nodes_ = std::move(tree.nodes);
    refs_.resize(tree.order.size());
    bounds_.resize(tree.order.size());
    tbb::parallel_for(tbb::blocked_range<size_t>(0, tree.order.size(), 4096),
                      [&](const tbb::blocked_range<size_t>& part) {
                        for (size_t i = part.begin(); i < part.end(); ++i) {
                          refs_[i] = bounded.refs[tree.order[i]];
                          bounds_[i] = bounded.bounds[tree.order[i]];
                        }
                      });
  }

  std::shared_ptr<const FrameScene> frame_;
  double scale_ = 1;  ///< Metres a unit of the nodes' bounds.
  std::vector<Node> nodes_;
  std::vector<TriangleRef> refs_;
  std::vector<ViewBounds> bounds_;  ///< One a reference.
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
