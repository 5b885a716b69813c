#include "worker/engine/accel/bvh.h"

#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/accel/embree.h"
#include "worker/engine/accel/frustum_cull.h"
#include "worker/engine/accel/triangle_refs.h"
#include "worker/engine/accel/view_scale.h"

namespace shutterline::engine {
namespace {

constexpr unsigned kBranching = 4;
constexpr unsigned kMaxLeafRefs = 8;
/// Far above what a sensible scene needs: only nested triangles of exponentially growing size come near.
constexpr unsigned kMaxDepth = 512;
void Extend(ViewBounds& bounds, const ViewBounds& other) {
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lower[axis] = std::min(bounds.lower[axis], other.lower[axis]);
    bounds.upper[axis] = std::max(bounds.upper[axis], other.upper[axis]);
  }
}

/// A node as Embree's builder makes it, in the builder's memory: children, or else references.
struct BuildNode {
  unsigned child_count = 0, ref_count = 0;
  BuildNode* children[kBranching] = {};
  uint32_t refs[kMaxLeafRefs] = {};

  static void* MakeInner(RTCThreadLocalAllocator allocator, unsigned child_count, void*) {
    auto* node = new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), alignof(BuildNode))) BuildNode;
    node->child_count = child_count;
    return node;
  }
  static void SetChildren(void* node, void** children, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) {
      static_cast<BuildNode*>(node)->children[i] = static_cast<BuildNode*>(children[i]);
    }
  }
  /// Bounds are recomputed when the tree is flattened.
  static void IgnoreBounds(void*, const RTCBounds**, unsigned, void*) {}
  static void* MakeLeaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, size_t count,
                        void*) {
    auto* node = new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), alignof(BuildNode))) BuildNode;
    node->ref_count = unsigned(count);
    for (size_t i = 0; i < count; ++i) node->refs[i] = primitives[i].primID;
    return node;
  }
};

/// Nodes in preorder, so that the references below any node are one range of `refs_` and walking the tree
/// needs no stack: a node's first child follows it, and `skip` is where one goes on without them.
///
/// A triangle is collected if, for one of its references, neither the bounds nor the hull lie outside: what
/// a node decides for all of its references is what each would decide alone. So the answer does not depend on
/// the tree, which is not the same for every number of threads.
class FlatBvh : public Bvh {
 public:
  explicit FlatBvh(std::shared_ptr<const FrameScene> frame)
      : frame_(std::move(frame)), scale_(ViewScale(*frame_)) {}

  absl::Status BuildTree(int threads) {
    // More threads than processors would only make TBB complain.
    tbb::task_arena arena(std::clamp(threads, 1, tbb::info::default_concurrency()));
    return arena.execute([&] { return BuildTreeInArena(); });
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
  struct Node {
    ViewBounds bounds;
    uint32_t skip;       ///< The next node that is not below this one.
    uint32_t first_ref;  ///< Its references end where those of node `skip` begin.
  };

  absl::Status BuildTreeInArena() {
    if (frame_->triangles.empty()) return absl::OkStatus();

    // Bound every triangle over the shutter, or over parts of it.
    const std::vector<TriangleRef> refs = MakeTriangleRefs(*frame_);
    const size_t count = refs.size();
    std::vector<RTCBuildPrimitive> primitives(count);
    std::vector<ViewBounds> bounds(count);  // The builder reorders its primitives.
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 4096),
                      [&](const tbb::blocked_range<size_t>& part) {
                        for (size_t i = part.begin(); i < part.end(); ++i) {
                          const ViewBounds& b = bounds[i] = BoundsOf(*frame_, refs[i], scale_);
                          primitives[i] = {b.lower[0], b.lower[1], b.lower[2], 0,
                                           b.upper[0], b.upper[1], b.upper[2], uint32_t(i)};
                        }
                      });

    // Let Embree build a tree, by surface area; by Morton order where that would get too deep.
    SL_ASSIGN_OR_RETURN(const EmbreeDevice device, MakeEmbreeDevice());
    const EmbreeBvh bvh(rtcNewBVH(device.get()));
    SL_RETURN_IF_ERROR(EmbreeStatus(device.get(), "build BVH"));
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.maxBranchingFactor = kBranching;
    arguments.maxDepth = kMaxDepth;
    arguments.maxLeafSize = kMaxLeafRefs;
    arguments.bvh = bvh.get();
    arguments.primitives = primitives.data();
    arguments.primitiveCount = arguments.primitiveArrayCapacity = count;
    arguments.createNode = &BuildNode::MakeInner;
    arguments.setNodeChildren = &BuildNode::SetChildren;
    arguments.setNodeBounds = &BuildNode::IgnoreBounds;
    arguments.createLeaf = &BuildNode::MakeLeaf;
    absl::Status status;
    const void* root = nullptr;
    for (const RTCBuildQuality quality : {RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_LOW}) {
      arguments.buildQuality = quality;
      root = rtcBuildBVH(&arguments);
      if (root != nullptr) break;
      status = EmbreeStatus(device.get(), "build BVH");
    }
    if (root == nullptr) return status.ok() ? absl::InternalError("build BVH: Embree made no tree") : status;

    // Flatten it.
    refs_.reserve(count);
    bounds_.reserve(count);
    Flatten(*static_cast<const BuildNode*>(root), refs, bounds);
    nodes_.push_back({{}, uint32_t(nodes_.size()), uint32_t(refs_.size())});
    nodes_.shrink_to_fit();
    if (refs_.size() != count) return absl::InternalError("build BVH: Embree lost triangles");
    return absl::OkStatus();
  }

  /// Appends `built` and all below it; returns its bounds. As deep a recursion as the tree.
  ViewBounds Flatten(const BuildNode& built, const std::vector<TriangleRef>& refs,
                     const std::vector<ViewBounds>& bounds) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    ViewBounds hull{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    const size_t n = nodes_.size();
    nodes_.push_back({hull, 0, uint32_t(refs_.size())});
    for (unsigned i = 0; i < built.ref_count; ++i) {
      refs_.push_back(refs[built.refs[i]]);
      bounds_.push_back(bounds[built.refs[i]]);
      Extend(hull, bounds_.back());
    }
    for (unsigned i = 0; i < built.child_count; ++i) Extend(hull, Flatten(*built.children[i], refs, bounds));
    nodes_[n].bounds = hull;
    nodes_[n].skip = uint32_t(nodes_.size());
    return hull;
  }

  std::shared_ptr<const FrameScene> frame_;
  double scale_;  ///< Metres a unit of the nodes' bounds.
  std::vector<Node> nodes_;
  std::vector<TriangleRef> refs_;
  std::vector<ViewBounds> bounds_;  ///< One a reference.
};

}  // namespace

absl::StatusOr<std::unique_ptr<const Bvh>> Bvh::Build(std::shared_ptr<const FrameScene> frame, int threads) {
  auto bvh = std::make_unique<FlatBvh>(std::move(frame));
  SL_RETURN_IF_ERROR(bvh->BuildTree(threads));
  return std::unique_ptr<const Bvh>(std::move(bvh));
}

}  // namespace shutterline::engine
