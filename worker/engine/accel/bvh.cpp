#include "worker/engine/accel/bvh.h"

#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/accel/embree.h"
#include "worker/engine/accel/frustum_cull.h"
#include "worker/engine/accel/view_scale.h"

namespace shutterline::engine {
namespace {

constexpr unsigned kBranching = 4;
constexpr unsigned kMaxLeafTriangles = 8;
/// Far above what a sensible scene needs: only nested triangles of exponentially growing size come near.
constexpr unsigned kMaxDepth = 512;
/// Embree takes no coordinates from about 2^60 on. Scaled ones stay below 2^21.
constexpr float kEmbreeLimit = 0x1p60f;

/// The nearest float not above (not below) `value`.
float RoundDown(double value) {
  const float f = float(std::clamp(value, -double(kEmbreeLimit), double(kEmbreeLimit)));
  return double(f) > value ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float RoundUp(double value) {
  return -RoundDown(-value);
}

void Extend(ViewBounds& bounds, const ViewBounds& other) {
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lower[axis] = std::min(bounds.lower[axis], other.lower[axis]);
    bounds.upper[axis] = std::max(bounds.upper[axis], other.upper[axis]);
  }
}

/// How far ViewFromRaster(p) may be from the exact view-space point: a few roundings of its terms.
V3d InverseError(const FrameView& view, const RasterPoint& p) {
  constexpr double kFewRoundings = 4 * std::numeric_limits<double>::epsilon();
  return kFewRoundings * V3d((std::abs(p.x) + std::abs(view.center_x * p.w)) / std::abs(view.scale_x),
                             (std::abs(p.y) + std::abs(view.center_y * p.w)) / std::abs(view.scale_y),
                             view.perspective
                                 ? std::abs(p.w)
                                 : std::abs(view.zfar) + std::abs(p.z * (view.zfar - view.znear)));
}

/// The hull of a triangle's control points holds it at every instant.
ViewBounds SweptBounds(const FrameScene& frame, const FrameTriangle& triangle, double scale) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  V3d lower(kInfinity), upper(-kInfinity);
  const FramePrimitive& primitive = frame.primitives[triangle.primitive];
  for (const uint32_t vertex : triangle.vertices) {
    for (int i = 0; i < primitive.PointsPerVertex(); ++i) {
      const RasterPoint& control_point = frame.ControlPoint(primitive, vertex, i);
      const V3d p = frame.view.ViewFromRaster(control_point);
      const V3d error = InverseError(frame.view, control_point);
      for (int axis = 0; axis < 3; ++axis) {
        lower[axis] = std::min(lower[axis], p[axis] - error[axis]);
        upper[axis] = std::max(upper[axis], p[axis] + error[axis]);
      }
    }
  }
  ViewBounds bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lower[axis] = RoundDown(lower[axis] / scale);
    bounds.upper[axis] = RoundUp(upper[axis] / scale);
  }
  return bounds;
}

/// A node as Embree's builder makes it, in the builder's memory: children, or else triangles.
struct BuildNode {
  unsigned child_count = 0, triangle_count = 0;
  BuildNode* children[kBranching] = {};
  uint32_t triangles[kMaxLeafTriangles] = {};

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
    node->triangle_count = unsigned(count);
    for (size_t i = 0; i < count; ++i) node->triangles[i] = primitives[i].primID;
    return node;
  }
};

/// Nodes in preorder, so that the triangles below any node are one range of `triangles_` and walking the
/// tree needs no stack: a node's first child follows it, and `skip` is where one goes on without them.
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
        const auto first = triangles_.begin() + node.first_triangle;
        const auto last = triangles_.begin() + nodes_[node.skip].first_triangle;
        if (side == TileFrustum::Side::kInside) {
          triangles.insert(triangles.end(), first, last);
        } else {
          std::copy_if(first, last, std::back_inserter(triangles), [&](uint32_t triangle) {
            return frustum.MayContain(*frame_, frame_->triangles[triangle]);
          });
        }
      }
      n = node.skip;
    }
  }

 private:
  struct Node {
    ViewBounds bounds;
    uint32_t skip;            ///< The next node that is not below this one.
    uint32_t first_triangle;  ///< Its triangles end where those of node `skip` begin.
  };

  absl::Status BuildTreeInArena() {
    const size_t count = frame_->triangles.size();
    if (count == 0) return absl::OkStatus();

    // Bound every triangle over the shutter.
    std::vector<RTCBuildPrimitive> primitives(count);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 4096),
                      [&](const tbb::blocked_range<size_t>& part) {
                        for (size_t i = part.begin(); i < part.end(); ++i) {
                          const ViewBounds bounds = SweptBounds(*frame_, frame_->triangles[i], scale_);
                          primitives[i] = {bounds.lower[0], bounds.lower[1], bounds.lower[2], 0,
                                           bounds.upper[0], bounds.upper[1], bounds.upper[2], uint32_t(i)};
                        }
                      });
    std::vector<ViewBounds> bounds(count);  // The builder reorders its primitives.
    for (size_t i = 0; i < count; ++i) {
      const RTCBuildPrimitive& p = primitives[i];
      bounds[i] = {{p.lower_x, p.lower_y, p.lower_z}, {p.upper_x, p.upper_y, p.upper_z}};
    }

    // Let Embree build a tree, by surface area; by Morton order where that would get too deep.
    SL_ASSIGN_OR_RETURN(const EmbreeDevice device, MakeEmbreeDevice());
    const EmbreeBvh bvh(rtcNewBVH(device.get()));
    SL_RETURN_IF_ERROR(EmbreeStatus(device.get(), "build BVH"));
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.maxBranchingFactor = kBranching;
    arguments.maxDepth = kMaxDepth;
    arguments.maxLeafSize = kMaxLeafTriangles;
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
    triangles_.reserve(count);
    Flatten(*static_cast<const BuildNode*>(root), bounds);
    nodes_.push_back({{}, uint32_t(nodes_.size()), uint32_t(triangles_.size())});
    nodes_.shrink_to_fit();
    if (triangles_.size() != count) return absl::InternalError("build BVH: Embree lost triangles");
    return absl::OkStatus();
  }

  /// Appends `built` and all below it; returns its bounds. As deep a recursion as the tree.
  ViewBounds Flatten(const BuildNode& built, const std::vector<ViewBounds>& bounds) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    ViewBounds hull{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    const size_t n = nodes_.size();
    nodes_.push_back({hull, 0, uint32_t(triangles_.size())});
    for (unsigned i = 0; i < built.triangle_count; ++i) {
      triangles_.push_back(built.triangles[i]);
      Extend(hull, bounds[built.triangles[i]]);
    }
    for (unsigned i = 0; i < built.child_count; ++i) Extend(hull, Flatten(*built.children[i], bounds));
    nodes_[n].bounds = hull;
    nodes_[n].skip = uint32_t(nodes_.size());
    return hull;
  }

  std::shared_ptr<const FrameScene> frame_;
  double scale_;  ///< Metres a unit of the nodes' bounds.
  std::vector<Node> nodes_;
  std::vector<uint32_t> triangles_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<const Bvh>> Bvh::Build(std::shared_ptr<const FrameScene> frame, int threads) {
  auto bvh = std::make_unique<FlatBvh>(std::move(frame));
  SL_RETURN_IF_ERROR(bvh->BuildTree(threads));
  return std::unique_ptr<const Bvh>(std::move(bvh));
}

}  // namespace shutterline::engine
