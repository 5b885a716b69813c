// A tree's triangles against the plane of a line. Included once per instruction set, by kernels.cpp.
#if defined(SHUTTERLINE_OCCLUSION_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_OCCLUSION_WALK_INL_H
#undef SHUTTERLINE_OCCLUSION_WALK_INL_H
#else
#define SHUTTERLINE_OCCLUSION_WALK_INL_H
#endif

#include <hwy/highway.h>

#include <cmath>

#include "worker/engine/occlusion/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

class Walker {
 public:
  HWY_INLINE Walker(const OccluderTree& tree, const LineQuery& query, LineSegments& segments)
      : tree_(tree), query_(query), segments_(segments) {
    const V3d from_centre = query.point - tree.centre;
    for (int axis = 0; axis < 3; ++axis) {
      point_[axis] = float(from_centre[axis]);
      along_[axis] = float(query.along[axis]);
      up_[axis] = float(query.up[axis]);
      plane_[axis] = float(query.plane[axis]);
      face_[axis] = float(query.face[axis]);
    }
    // As OccluderTree widens boxes by the roundings of their own numbers.
    slack_ = 0x1p-20f * (std::abs(point_[0]) + std::abs(point_[1]) + std::abs(point_[2]));
    reach_ = std::isfinite(query.radius) ? float(query.radius) * (1 + 0x1p-20f) + slack_ : -1;
  }

  HWY_INLINE void Run() {
    stack_[0] = {0, -kLineEnd, kLineEnd, 0};
    int depth = 1;
    while (depth > 0) {
      const Entry top = stack_[--depth];
      // What was put off may have been hidden since.
      if (segments_.cover().Holds(top.begin, top.end)) continue;
      if (top.node < 0) {
        const LeafBlocks& leaf = tree_.leaves[size_t(~top.node)];
        for (uint32_t b = leaf.begin; b < leaf.end; ++b) CutBlock(tree_.blocks[b]);
      } else {
        depth = OpenNode(top.node, depth);
      }
    }
  }

 private:
  using Floats = hn::CappedTag<float, kTreeWidth>;
  using FloatsV = hn::Vec<Floats>;
  using Doubles = hn::CappedTag<double, kTreeWidth>;
  using DoublesV = hn::Vec<Doubles>;

  struct Entry {
    int32_t node;        ///< Or ~leaf.
    int32_t begin, end;  ///< Positions on the line between which it is seen.
    float distance;      ///< Squared, of its middle.
  };
  /// Eight children a level, and a tree cut in halves has few levels; see BuildBoundsTree.
  static constexpr int kMostEntries = 4096;

  static HWY_INLINE FloatsV Dot(const float* a, FloatsV x, FloatsV y, FloatsV z) {
    const Floats d;
    return hn::Add(hn::Add(hn::Mul(hn::Set(d, a[0]), x), hn::Mul(hn::Set(d, a[1]), y)),
                   hn::Mul(hn::Set(d, a[2]), z));
  }
  static HWY_INLINE FloatsV AbsDot(const float* a, FloatsV x, FloatsV y, FloatsV z) {
    const Floats d;
    return hn::Add(hn::Add(hn::Mul(hn::Set(d, std::abs(a[0])), x), hn::Mul(hn::Set(d, std::abs(a[1])), y)),
                   hn::Mul(hn::Set(d, std::abs(a[2])), z));
  }

  /// Pushes the children that the line may see, the nearest last. Returns the new depth.
  HWY_INLINE int OpenNode(int32_t node, int depth) {
    const Floats d;
    const float* const numbers = tree_.Node(query_.span, node);
    HWY_ALIGN float least[kTreeWidth], most[kTreeWidth], distance[kTreeWidth];
    uint64_t hit = 0;
    for (size_t i = 0; i < kTreeWidth; i += hn::Lanes(d)) {
      // Place the boxes at the instant.
      FloatsV box[6];
      for (size_t k = 0; k < 6; ++k) {
        box[k] = hn::LoadU(d, numbers + k * kTreeWidth + i);
        if (tree_.moves) {
          const FloatsV gain = hn::LoadU(d, numbers + kNodePlane + k * kTreeWidth + i);
          box[k] = hn::Add(box[k], hn::Mul(hn::Set(d, query_.in_span), gain));
        }
      }
      const FloatsV x = hn::Sub(box[0], hn::Set(d, point_[0]));
      const FloatsV y = hn::Sub(box[1], hn::Set(d, point_[1]));
      const FloatsV z = hn::Sub(box[2], hn::Set(d, point_[2]));
      const FloatsV slack = hn::Set(d, slack_);

      // The plane of the line passes through them; they reach over face and horizon.
      auto seen =
          hn::Le(hn::Abs(Dot(plane_, x, y, z)), hn::Add(AbsDot(plane_, box[3], box[4], box[5]), slack));
      const FloatsV over =
          hn::Add(Dot(face_, x, y, z), hn::Add(AbsDot(face_, box[3], box[4], box[5]), slack));
      seen = hn::And(seen, hn::Ge(over, hn::Zero(d)));
      const FloatsV up = Dot(up_, x, y, z), half_up = hn::Add(AbsDot(up_, box[3], box[4], box[5]), slack);
      seen = hn::And(seen, hn::Ge(hn::Add(up, half_up), hn::Zero(d)));
      if (reach_ >= 0) {
        const FloatsV zero = hn::Zero(d);
        const FloatsV fx = hn::Max(hn::Sub(hn::Abs(x), box[3]), zero);
        const FloatsV fy = hn::Max(hn::Sub(hn::Abs(y), box[4]), zero);
        const FloatsV fz = hn::Max(hn::Sub(hn::Abs(z), box[5]), zero);
        const FloatsV square = hn::Add(hn::Add(hn::Mul(fx, fx), hn::Mul(fy, fy)), hn::Mul(fz, fz));
        seen = hn::And(seen, hn::Le(square, hn::Set(d, reach_ * reach_ * (1 + 0x1p-20f))));
      }
      const uint64_t bits = BitsOf(d, seen);
      if (bits == 0) continue;
      hit |= bits << i;

      // Between which positions on the line they are seen: those of the corners of a rectangle.
      const FloatsV along = Dot(along_, x, y, z);
      const FloatsV half_along = hn::Add(AbsDot(along_, box[3], box[4], box[5]), slack);
      const FloatsV low = hn::Max(hn::Sub(up, half_up), hn::Zero(d)), high = hn::Add(up, half_up);
      const FloatsV left = hn::Sub(along, half_along), right = hn::Add(along, half_along);
      hn::Store(PositionOf(left, hn::IfThenElse(hn::Lt(left, hn::Zero(d)), low, high)), d, least + i);
      hn::Store(PositionOf(right, hn::IfThenElse(hn::Lt(right, hn::Zero(d)), high, low)), d, most + i);
      hn::Store(hn::Add(hn::Mul(along, along), hn::Mul(up, up)), d, distance + i);
    }
    const int first = depth;
    for (; hit != 0; hit &= hit - 1) {
      const size_t k = size_t(__builtin_ctzll(hit));
      const Entry entry{tree_.children[size_t(node)][k], Widened(least[k], -kPositionSlack),
                        Widened(most[k], kPositionSlack), distance[k]};
      if (segments_.cover().Holds(entry.begin, entry.end)) continue;
      int at = depth++;
      for (; at > first && stack_[at - 1].distance < entry.distance; --at) stack_[at] = stack_[at - 1];
      stack_[at] = entry;
    }
    return depth;
  }

  /// l of a direction; where that is nothing, something that is no number.
  static HWY_INLINE FloatsV PositionOf(FloatsV along, FloatsV up) {
    return hn::Div(along, hn::Sqrt(hn::Add(hn::Mul(along, along), hn::Mul(up, up))));
  }

  static constexpr float kPositionSlack = 0x1p-20f;
  /// What is no number goes to the line's end.
  static HWY_INLINE int32_t Widened(float l, float by) {
    const float wide = l + by;
    if (by < 0) return wide > -1 ? int32_t(wide * float(kLineEnd)) : -kLineEnd;
    return wide < 1 ? int32_t(wide * float(kLineEnd)) : kLineEnd;
  }

  template <class D, class M>
  static HWY_INLINE uint64_t BitsOf(D d, M mask) {
    uint8_t bits[8] = {};
    hn::StoreMaskBits(d, mask, bits);
    return bits[0] & ((uint64_t{1} << hn::Lanes(d)) - 1);
  }

  static HWY_INLINE DoublesV Dot(const V3d& a, const DoublesV* v) {
    const Doubles d;
    return hn::Add(hn::Add(hn::Mul(hn::Set(d, a.x), v[0]), hn::Mul(hn::Set(d, a.y), v[1])),
                   hn::Mul(hn::Set(d, a.z), v[2]));
  }

  /// A corner of each triangle relative to the point, at the instant.
  HWY_INLINE void Place(const double* points, const MotionWeights& motion, size_t corner, size_t lane,
                        DoublesV* v) const {
    const Doubles d;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double* const from = points + (corner * 3 + axis) * kTreeWidth + lane;
      DoublesV p = hn::LoadU(d, from);
      if (motion.count > 1) {
        p = hn::Mul(hn::Set(d, motion.weights[0]), p);
        for (int k = 1; k < motion.count; ++k) {
          p = hn::Add(p,
                      hn::Mul(hn::Set(d, motion.weights[size_t(k)]), hn::LoadU(d, from + k * kBlockPlane)));
        }
      }
      v[axis] = hn::Sub(p, hn::Set(d, query_.point[int(axis)]));
    }
  }

  HWY_INLINE void CutBlock(const OccluderBlock& block) {
    const Doubles d;
    const MotionWeights& motion = query_.motions[block.motion_class];
    const double* const points = tree_.points.data() + block.first + size_t(motion.first) * kBlockPlane;
    for (size_t i = 0; i < block.count; i += hn::Lanes(d)) {
      DoublesV corner[3][3], side[3];
      for (size_t k = 0; k < 3; ++k) {
        Place(points, motion, k, i, corner[k]);
        side[k] = Dot(query_.plane, corner[k]);
      }

      // One corner is alone on its side of the plane; the plane itself belongs to one side.
      const DoublesV zero = hn::Zero(d);
      const auto in0 = hn::Ge(side[0], zero), in1 = hn::Ge(side[1], zero), in2 = hn::Ge(side[2], zero);
      const auto differ01 = hn::Xor(in0, in1), differ02 = hn::Xor(in0, in2);
      const auto cut = hn::Or(differ01, differ02);
      uint64_t bits = BitsOf(d, cut);
      if (bits == 0) continue;

      // Something of it is over the face by more than rounding.
      DoublesV height = zero, reach = zero;
      for (size_t k = 0; k < 3; ++k) {
        height = hn::Max(height, Dot(query_.face, corner[k]));
        reach = hn::Max(
            reach, hn::Add(hn::Add(hn::Abs(corner[k][0]), hn::Abs(corner[k][1])), hn::Abs(corner[k][2])));
      }
      const DoublesV slack =
          hn::Add(hn::Set(d, kHeightRoundings * query_.size),
                  hn::Mul(hn::Set(d, kHeightRoundings * (query_.size * query_.inverse_height + 1)), reach));
      bits &= BitsOf(d, hn::Gt(height, slack));
      if (bits == 0) continue;

      // The edges from the corner that is alone, as sums of positive terms.
      DoublesV along[3], up[3], away[3];
      for (size_t k = 0; k < 3; ++k) {
        along[k] = Dot(query_.along, corner[k]);
        up[k] = Dot(query_.up, corner[k]);
        away[k] = hn::Abs(side[k]);
      }
      const auto alone1 = hn::AndNot(differ02, differ01), alone2 = hn::AndNot(differ01, differ02);
      const auto choose = [&](const DoublesV* v, DoublesV& a, DoublesV& b, DoublesV& c) HWY_ATTR {
        a = hn::IfThenElse(alone1, v[1], hn::IfThenElse(alone2, v[2], v[0]));
        b = hn::IfThenElse(alone1, v[0], v[1]);
        c = hn::IfThenElse(alone2, v[0], v[2]);
      };
      DoublesV away_a, away_b, away_c, along_a, along_b, along_c, up_a, up_b, up_c;
      choose(away, away_a, away_b, away_c);
      choose(along, along_a, along_b, along_c);
      choose(up, up_a, up_b, up_c);
      HWY_ALIGN double section[6][kTreeWidth];
      const auto mix = [&](DoublesV a, DoublesV b, DoublesV away_other)
                           HWY_ATTR { return hn::Add(hn::Mul(away_other, a), hn::Mul(away_a, b)); };
      hn::Store(mix(along_a, along_b, away_b), d, section[0]);
      hn::Store(mix(up_a, up_b, away_b), d, section[1]);
      hn::Store(hn::Add(away_a, away_b), d, section[2]);
      hn::Store(mix(along_a, along_c, away_c), d, section[3]);
      hn::Store(mix(up_a, up_c, away_c), d, section[4]);
      hn::Store(hn::Add(away_a, away_c), d, section[5]);
      for (; bits != 0; bits &= bits - 1) {
        const size_t lane = size_t(__builtin_ctzll(bits));
        if (i + lane >= block.count || block.triangles[i + lane] == query_.own_triangle) continue;
        segments_.Add({section[0][lane], section[1][lane], section[2][lane], section[3][lane],
                       section[4][lane], section[5][lane]});
      }
    }
  }

  const OccluderTree& tree_;
  const LineQuery& query_;
  LineSegments& segments_;
  float point_[3], along_[3], up_[3], plane_[3], face_[3];
  float slack_, reach_;
  Entry stack_[kMostEntries];
};

HWY_ATTR void WalkLineKernel(const OccluderTree& tree, const LineQuery& query, LineSegments& segments) {
  Walker(tree, query, segments).Run();
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
