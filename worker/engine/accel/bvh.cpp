#include "worker/engine/accel/bvh.h"

#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/accel/embree.h"
#include "worker/engine/accel/facing.h"
#include "worker/engine/accel/swept_bounds.h"
#include "worker/engine/accel/triangle_refs.h"
#include "worker/engine/accel/view_scale.h"

namespace shutterline::engine {
namespace {

constexpr unsigned kBranching = 4;
constexpr unsigned kMaxLeafRefs = 8;
/// Far above what a sensible scene needs: only nested triangles of exponentially growing size come near.
constexpr unsigned kMaxDepth = 512;

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
/// The tree is built in view space, where scenes are split well, but asked in the raster, where a tile and
/// what a triangle sweeps are rectangles. A triangle is collected if those of one of its references overlap
/// the tile's: what a node decides for all of its references is what each would decide alone. So the answer
/// does not depend on the tree, which is not the same for every number of threads.
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

  absl::Status BuildTreeInArena() {
    if (frame_->triangles.empty()) return absl::OkStatus();

    // Bound every triangle over the shutter, or over parts of it.
    const std::vector<TriangleRef> refs = MakeTriangleRefs(*frame_);
    const size_t count = refs.size();
    std::vector<RTCBuildPrimitive> primitives(count);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 4096),
                      [&](const tbb::blocked_range<size_t>& part) {
                        for (size_t i = part.begin(); i < part.end(); ++i) {
                          const ViewBounds b = BoundsOf(*frame_, refs[i], scale_);
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
    Flatten(*static_cast<const BuildNode*>(root), refs);
    nodes_.push_back({{}, uint32_t(nodes_.size()), uint32_t(refs_.size())});
    nodes_.shrink_to_fit();
    if (refs_.size() != count) return absl::InternalError("build BVH: Embree lost triangles");
    BoundInRaster();
    return absl::OkStatus();
  }

  /// Appends `built` and all below it. As deep a recursion as the tree.
  void Flatten(const BuildNode& built, const std::vector<TriangleRef>& refs) {
    const size_t n = nodes_.size();
    nodes_.push_back({{}, 0, uint32_t(refs_.size())});
    for (unsigned i = 0; i < built.ref_count; ++i) refs_.push_back(refs[built.refs[i]]);
    for (unsigned i = 0; i < built.child_count; ++i) Flatten(*built.children[i], refs);
    nodes_[n].skip = uint32_t(nodes_.size());
  }

  /// Bounds references and nodes in the raster, and drops the references that are never visible.
  void BoundInRaster() {
    bounds_.resize(refs_.size());
    const double far_depth = frame_->view.FarDepth();
    tbb::parallel_for(tbb::blocked_range<size_t>(0, refs_.size(), 1024),
                      [&](const tbb::blocked_range<size_t>& part) {
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
  double scale_;  ///< Metres a unit of the bounds that Embree is given.
  std::vector<Node> nodes_;
  std::vector<TriangleRef> refs_;
  std::vector<SweptBounds> bounds_;  ///< One a reference.
};

}  // namespace

absl::StatusOr<std::unique_ptr<const Bvh>> Bvh::Build(std::shared_ptr<const FrameScene> frame, int threads) {
  auto bvh = std::make_unique<FlatBvh>(std::move(frame));
  SL_RETURN_IF_ERROR(bvh->BuildTree(threads));
  return std::unique_ptr<const Bvh>(std::move(bvh));
}

}  // namespace shutterline::engine
