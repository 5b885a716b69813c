#include "worker/engine/occlusion/occluder_tree.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/base/check.h"
#include "worker/engine/accel/view_scale.h"
#include "worker/engine/occlusion/occluder_motion.h"

namespace shutterline::engine {
namespace {

/// Spans of the shutter where something moves on a curve: boxes move straight over each.
constexpr int kCurveSpans = 8;
/// Half extents are widened by this share of centre and extent: sixteen roundings of single precision, more
/// than a box's own numbers and a test against a plane have.
constexpr double kWiden = 0x1p-20;

class Builder {
 public:
  Builder(const FrameScene& frame, bool motion, OccluderTree& tree)
      : frame_(frame), motion_(motion), tree_(tree) {}

  void Build() {
    tree_.scale = ViewScale(frame_);
    Collect();
    if (triangles_.empty()) return;
    MakeBinaryTree();
    boxes_.resize(size_t(tree_.spans) * triangles_.size());
    const OccluderMotion motion{frame_, motion_, tree_.scale, tree_.centre, tree_.spans};
    tbb::parallel_for(tbb::blocked_range<size_t>(0, triangles_.size(), 1024),
                      [&](const tbb::blocked_range<size_t>& part) {
                        for (size_t i = part.begin(); i < part.end(); ++i) {
                          for (int span = 0; span < tree_.spans; ++span)
                            BoxOf(i, span) = motion.Bound(triangles_[i], span);
                        }
                      });
    tree_.places.resize(frame_.triangles.size());
    MakeNode(0);  // A lone leaf has a node above it, too.
    tree_.blocks.resize(tree_.blocks.size() + kTreeWidth);
    WriteNodes();
  }

 private:
  struct WideNode {
    std::array<uint32_t, kTreeWidth> below{};  ///< Numbers of the binary tree's nodes.
    int count = 0;
  };

  MovingBox& BoxOf(size_t i, int span) { return boxes_[size_t(span) * triangles_.size() + i]; }

  MotionClass ClassOf(const FramePrimitive& primitive) const {
    return motion_ && primitive.degree > 0 ? MotionClass{primitive.degree, primitive.pieces} : MotionClass{};
  }

  V3d InView(const RasterPoint& p) const { return frame_.view.ViewFromRaster(p) / tree_.scale; }

  /// Lists what may occlude, and the ways in which it moves.
  void Collect() {
    class_of_.resize(frame_.primitives.size());
    for (size_t p = 0; p < frame_.primitives.size(); ++p) {
      const FramePrimitive& primitive = frame_.primitives[p];
      if (primitive.material->alpha_mode != AlphaMode::kOpaque) continue;
      const MotionClass motion = ClassOf(primitive);
      const auto found = std::find(tree_.classes.begin(), tree_.classes.end(), motion);
      class_of_[p] = uint8_t(found - tree_.classes.begin());
      if (found == tree_.classes.end()) tree_.classes.push_back(motion);
      tree_.moves = tree_.moves || motion.degree > 0;
      if (motion.degree > 1 || motion.pieces > 1) tree_.spans = kCurveSpans;
      for (uint32_t i = 0; i < primitive.triangle_count; ++i) {
        triangles_.push_back(primitive.first_triangle + i);
      }
    }
  }

  void MakeBinaryTree() {
    std::vector<OccluderBox> boxes(triangles_.size());
    tbb::parallel_for(tbb::blocked_range<size_t>(0, triangles_.size(), 1024),
                      [&](const tbb::blocked_range<size_t>& part) {
                        for (size_t i = part.begin(); i < part.end(); ++i) {
                          const FrameTriangle& triangle = frame_.triangles[triangles_[i]];
                          const FramePrimitive& primitive = frame_.primitives[triangle.primitive];
                          for (const uint32_t vertex : triangle.vertices) {
                            boxes[i].Extend(InView(frame_.VertexAt(primitive, vertex, 0.5)));
                          }
                        }
                      });
    OccluderBox all;
    for (const OccluderBox& box : boxes) all.Extend(box);
    tree_.centre = 0.5 * all.lower + 0.5 * all.upper;
    // How triangles are grouped needs no more than these.
    std::vector<ViewBounds> bounds(boxes.size());
    for (size_t i = 0; i < boxes.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        bounds[i].lower[size_t(axis)] = float(boxes[i].lower[axis] - tree_.centre[axis]);
        bounds[i].upper[size_t(axis)] = float(boxes[i].upper[axis] - tree_.centre[axis]);
      }
    }
    binary_ = BuildBoundsTree(bounds);
  }

  bool IsLeaf(uint32_t n) const { return binary_.nodes[n].skip == n + 1; }
  uint32_t RefsOf(uint32_t n) const {
    return binary_.nodes[binary_.nodes[n].skip].first_ref - binary_.nodes[n].first_ref;
  }

  /// Makes a wide node of what is below node `n` of the binary tree; returns its number.
  int32_t MakeNode(uint32_t n) {
    // Open the child that holds most, until there are eight.
    WideNode node;
    node.below[0] = n;
    node.count = 1;
    while (node.count < kTreeWidth) {
      int most = -1;
      for (int k = 0; k < node.count; ++k) {
        if (IsLeaf(node.below[size_t(k)])) continue;
        if (most < 0 || RefsOf(node.below[size_t(k)]) > RefsOf(node.below[size_t(most)])) most = k;
      }
      if (most < 0) break;
      const uint32_t left = node.below[size_t(most)] + 1;
      node.below[size_t(most)] = left;
      node.below[size_t(node.count++)] = binary_.nodes[left].skip;
    }
    const size_t number = wide_.size();
    wide_.push_back(node);
    tree_.children.emplace_back();
    tree_.children[number].fill(OccluderTree::kNoChild);
    for (int k = 0; k < node.count; ++k) {
      const uint32_t child = node.below[size_t(k)];
      const int32_t made = IsLeaf(child) ? ~MakeLeaf(child) : MakeNode(child);
      tree_.children[number][size_t(k)] = made;
    }
    return int32_t(number);
  }

  /// One block for each class of motion in the leaf. Returns where the first begins, over four.
  int32_t MakeLeaf(uint32_t n) {
    const uint32_t begin = binary_.nodes[n].first_ref, end = begin + RefsOf(n);
    const size_t first = tree_.blocks.size();
    size_t last = first;
    std::vector<uint32_t> members;
    for (size_t c = 0; c < tree_.classes.size(); ++c) {
      members.clear();
      for (uint32_t r = begin; r < end; ++r) {
        const uint32_t triangle = triangles_[binary_.order[r]];
        if (class_of_[frame_.triangles[triangle].primitive] == c) members.push_back(triangle);
      }
      if (members.empty()) continue;
      last = tree_.blocks.size();
      WriteBlock(members, uint8_t(c));
    }
    BlockHeader header;
    std::memcpy(static_cast<void*>(&header), tree_.blocks.data() + last, sizeof header);
    header.is_last = 1;
    std::memcpy(tree_.blocks.data() + last, &header, sizeof header);
    return int32_t(first / 4);
  }

  void WriteBlock(const std::vector<uint32_t>& members, uint8_t motion_class) {
    SL_CHECK(members.size() <= BlockHeader::kMostTriangles);
    BlockHeader header;
    header.motion_class = motion_class;
    header.is_last = 0;
    // Number the vertices, each once.
    struct Vertex {
      const FramePrimitive* primitive;
      uint32_t number;
    };
    std::vector<Vertex> vertices;
    const size_t first = tree_.blocks.size();
    for (const uint32_t number : members) {
      const FrameTriangle& triangle = frame_.triangles[number];
      tree_.places[number] = {uint32_t(first / 4), header.count};
      for (size_t corner = 0; corner < 3; ++corner) {
        const uint32_t vertex = triangle.vertices[corner];
        size_t v = 0;
        while (v < vertices.size() && vertices[v].number != vertex) ++v;
        if (v == vertices.size()) vertices.push_back({&frame_.primitives[triangle.primitive], vertex});
        header.corners[header.count][corner] = uint8_t(v);
        header.masks[header.count] |= uint32_t{1} << v;
      }
      ++header.count;
    }
    header.vertices = uint8_t(vertices.size());
    header.stride = uint8_t((vertices.size() + 3) / 4 * 4);

    const size_t stride = header.stride;
    const int planes = tree_.classes[motion_class].Points();
    tree_.blocks.resize(first + kHeaderSize + size_t(planes) * 3 * stride);
    std::memcpy(tree_.blocks.data() + first, &header, sizeof header);
    double* out = tree_.blocks.data() + first + kHeaderSize;
    for (int plane = 0; plane < planes; ++plane) {
      for (size_t v = 0; v < vertices.size(); ++v) {
        const auto& [primitive, number] = vertices[v];
        const V3d p = InView(planes > 1 ? frame_.ControlPoint(*primitive, number, plane)
                                        : frame_.VertexAt(*primitive, number, 0.5));
        for (int axis = 0; axis < 3; ++axis) out[size_t(axis) * stride + v] = p[axis];
      }
      out += 3 * stride;
    }
  }

  void WriteNodes() {
    tree_.node_count = int(wide_.size());
    const size_t size = size_t(tree_.moves ? 2 : 1) * kNodePlane;
    tree_.nodes.assign(size_t(tree_.spans) * wide_.size() * size, 0);
    for (int span = 0; span < tree_.spans; ++span) {
      // Children come after their parents, in the binary tree.
      std::vector<MovingBox> of(binary_.nodes.size());
      for (size_t n = binary_.nodes.size() - 1; n-- > 0;) {
        const uint32_t skip = binary_.nodes[n].skip;
        if (IsLeaf(uint32_t(n))) {
          for (uint32_t r = binary_.nodes[n].first_ref; r < binary_.nodes[skip].first_ref; ++r) {
            of[n].Extend(BoxOf(binary_.order[r], span));
          }
        } else {
          of[n].Extend(of[n + 1]);
          of[n].Extend(of[binary_.nodes[n + 1].skip]);
        }
      }
      for (size_t n = 0; n < wide_.size(); ++n) {
        float* const out = tree_.nodes.data() + (size_t(span) * wide_.size() + n) * size;
        for (size_t k = 0; k < kTreeWidth; ++k) {
          if (int(k) < wide_[n].count) {
            WriteChild(of[wide_[n].below[k]], k, out);
          } else {
            for (size_t axis = 3; axis < 6; ++axis) {
              out[axis * kTreeWidth + k] = -std::numeric_limits<float>::infinity();
            }
          }
        }
      }
    }
  }

  void WriteChild(const MovingBox& box, size_t k, float* out) const {
    for (int axis = 0; axis < 3; ++axis) {
      const auto write = [&](const OccluderBox& b, float& centre, float& extent) {
        const double c = 0.5 * b.lower[axis] + 0.5 * b.upper[axis];
        const double e = 0.5 * b.upper[axis] - 0.5 * b.lower[axis];
        centre = float(c);
        extent = float(e + kWiden * (e + std::abs(c)) + double(std::numeric_limits<float>::min()));
      };
      float c0, e0, c1, e1;
      write(box.open, c0, e0);
      write(box.close, c1, e1);
      const size_t at = size_t(axis) * kTreeWidth + k;
      out[at] = c0;
      out[at + 3 * kTreeWidth] = e0;
      if (!tree_.moves) continue;
      out[at + kNodePlane] = c1 - c0;
      out[at + kNodePlane + 3 * kTreeWidth] = e1 - e0;
    }
  }

  const FrameScene& frame_;
  const bool motion_;
  OccluderTree& tree_;
  std::vector<uint8_t> class_of_;    ///< By primitive.
  std::vector<uint32_t> triangles_;  ///< That may occlude.
  std::vector<MovingBox> boxes_;     ///< Span by span.
  BoundsTree binary_;
  std::vector<WideNode> wide_;
};

}  // namespace

OccluderTree OccluderTree::Build(const FrameScene& frame, bool motion) {
  OccluderTree tree;
  Builder(frame, motion, tree).Build();
  return tree;
}

}  // namespace shutterline::engine
