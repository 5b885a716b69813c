// A tree's triangles against the plane of a line. Included once per instruction set, by kernels.cpp.
#if defined(SHUTTERLINE_OCCLUSION_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_OCCLUSION_WALK_INL_H
#undef SHUTTERLINE_OCCLUSION_WALK_INL_H
#else
#define SHUTTERLINE_OCCLUSION_WALK_INL_H
#endif

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <cmath>
#include <cstring>

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
        CutLeaf(uint32_t(~top.node));
      } else {
        depth = OpenNode(top.node, depth);
      }
    }
    AddWaiting();
  }

 private:
  using Floats = hn::CappedTag<float, kTreeWidth>;
  using FloatsV = hn::Vec<Floats>;
  using Masks = hn::CappedTag<uint32_t, BlockHeader::kMostTriangles>;
  using Doubles = hn::CappedTag<double, kTreeWidth>;
  /// A last vector may begin at any multiple of four.
  static constexpr int kMostLanes = BlockHeader::kMostVertices + kTreeWidth;
  using DoublesV = hn::Vec<Doubles>;

  struct Entry {
    int32_t node;        ///< Or ~leaf.
    int32_t begin, end;  ///< Positions on the line between which it is seen.
    float distance;      ///< Squared, of its middle.
  };
  /// Seven stay behind a level. Every cut of BuildBoundsTree halves a set or an extent, so three axes have
  /// fewer levels than three floats have digits and exponents, some 900.
  static constexpr int kMostEntries = 8192;

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
    HWY_ALIGN int32_t begin[kTreeWidth], end[kTreeWidth];
    HWY_ALIGN float distance[kTreeWidth];
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
      const FloatsV zero = hn::Zero(d), one = hn::Set(d, 1), margin = hn::Set(d, kPositionSlack);
      const FloatsV least = hn::Sub(PositionOf(left, hn::IfThenElse(hn::Lt(left, zero), low, high)), margin);
      const FloatsV most = hn::Add(PositionOf(right, hn::IfThenElse(hn::Lt(right, zero), high, low)), margin);
      // What is no number goes to the line's end.
      StorePositions(hn::IfThenElse(hn::Gt(least, hn::Neg(one)), least, hn::Neg(one)), begin + i);
      StorePositions(hn::IfThenElse(hn::Lt(most, one), most, one), end + i);
      hn::Store(hn::Add(hn::Mul(along, along), hn::Mul(up, up)), d, distance + i);
    }
    const int first = depth;
    for (; hit != 0; hit &= hit - 1) {
      const size_t k = size_t(__builtin_ctzll(hit));
      const Entry entry{tree_.children[size_t(node)][k], begin[k], end[k], distance[k]};
      Prefetch(entry.node);
      int at = depth++;
      for (; at > first && stack_[at - 1].distance < entry.distance; --at) stack_[at] = stack_[at - 1];
      stack_[at] = entry;
    }
    return depth;
  }

  /// Nodes and blocks are spread over more memory than caches hold, but are known well before their turn.
  HWY_INLINE void Prefetch(int32_t node) const {
    const char* from;
    int lines;
    if (node < 0) {
      from = reinterpret_cast<const char*>(tree_.blocks.data() + size_t(uint32_t(~node)) * 4);
      lines = tree_.moves ? 7 : 5;
    } else {
      from = reinterpret_cast<const char*>(tree_.Node(query_.span, node));
      lines = tree_.moves ? 6 : 3;
      hwy::Prefetch(&tree_.children[size_t(node)]);
    }
    for (int i = 0; i < lines; ++i) hwy::Prefetch(from + 64 * i);
  }

  /// l of a direction; where that is nothing, something that is no number.
  static HWY_INLINE FloatsV PositionOf(FloatsV along, FloatsV up) {
    return hn::Div(along, hn::Sqrt(hn::Add(hn::Mul(along, along), hn::Mul(up, up))));
  }

  static constexpr float kPositionSlack = 0x1p-20f;
  static HWY_INLINE void StorePositions(FloatsV l, int32_t* positions) {
    const hn::RebindToSigned<Floats> di;
    hn::StoreU(hn::ConvertTo(di, hn::Mul(l, hn::Set(Floats(), float(kLineEnd)))), di, positions);
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

  HWY_INLINE void CutLeaf(uint32_t block) {
    while (true) {
      const double* const numbers = tree_.blocks.data() + size_t(block) * 4;
      BlockHeader header;
      std::memcpy(static_cast<void*>(&header), numbers, sizeof header);
      CutBlock(header, numbers + kHeaderSize, block == query_.own.block ? query_.own.number : -1);
      if (header.is_last) return;
      const size_t points = size_t(tree_.classes[header.motion_class].Points());
      block += uint32_t((kHeaderSize + points * 3 * header.stride) / 4);
    }
  }

  /// What the plane makes of a block's vertices.
  struct CutVertices {
    HWY_ALIGN double from_point[3][kMostLanes];
    HWY_ALIGN double side[kMostLanes], along[kMostLanes], up[kMostLanes];
    uint32_t over_plane = 0, over_face = 0;  ///< By bit.
  };

  HWY_INLINE void CutBlock(const BlockHeader& header, const double* points, int own) {
    const Doubles d;
    const MotionWeights& motion = query_.motions[header.motion_class];
    const size_t stride = header.stride;
    const double* const from = points + size_t(motion.first) * 3 * stride;
    CutVertices cut;
    for (size_t i = 0; i < header.vertices; i += hn::Lanes(d)) {
      // Place vertices at the instant, relative to the point.
      DoublesV v[3];
      for (size_t axis = 0; axis < 3; ++axis) {
        const double* at = from + axis * stride + i;
        DoublesV p = hn::LoadU(d, at);
        if (motion.count > 1) {
          p = hn::Mul(hn::Set(d, motion.weights[0]), p);
          for (int k = 1; k < motion.count; ++k) {
            at += 3 * stride;
            p = hn::Add(p, hn::Mul(hn::Set(d, motion.weights[size_t(k)]), hn::LoadU(d, at)));
          }
        }
        v[axis] = hn::Sub(p, hn::Set(d, query_.point[int(axis)]));
        hn::StoreU(v[axis], d, cut.from_point[axis] + i);
      }
      const DoublesV side = Dot(query_.plane, v);
      hn::StoreU(side, d, cut.side + i);
      cut.over_plane |= uint32_t(BitsOf(d, hn::Ge(side, hn::Zero(d))) << i);

      // Which are over the face by more than rounding.
      const DoublesV reach = hn::Add(hn::Add(hn::Abs(v[0]), hn::Abs(v[1])), hn::Abs(v[2]));
      const DoublesV slack =
          hn::Add(hn::Set(d, kHeightRoundings * query_.size),
                  hn::Mul(hn::Set(d, kHeightRoundings * (query_.size * query_.inverse_height + 1)), reach));
      cut.over_face |= uint32_t(BitsOf(d, hn::Gt(Dot(query_.face, v), slack)) << i);
    }
    const uint32_t all = (uint32_t{1} << header.vertices) - 1;
    if ((cut.over_plane & all) == 0 || (cut.over_plane & all) == all || (cut.over_face & all) == 0) return;

    // Find the triangles with corners on both sides, one of them over the face.
    const Masks dm;
    uint64_t hit = 0;
    for (size_t i = 0; i < header.count; i += hn::Lanes(dm)) {
      const auto masks = hn::LoadU(dm, header.masks.data() + i);
      const auto over = hn::And(masks, hn::Set(dm, cut.over_plane));
      const auto high = hn::And(masks, hn::Set(dm, cut.over_face));
      const auto none = hn::Zero(dm);
      const auto misses = hn::Or(hn::Or(hn::Eq(over, none), hn::Eq(over, masks)), hn::Eq(high, none));
      hit |= BitsOf(dm, hn::Not(misses)) << i;
    }
    if (own >= 0) hit &= ~(uint64_t{1} << own);
    if (hit == 0) return;
    for (size_t k = 0; k < header.vertices; k += hn::Lanes(d)) {
      const DoublesV v[3] = {hn::LoadU(d, cut.from_point[0] + k), hn::LoadU(d, cut.from_point[1] + k),
                             hn::LoadU(d, cut.from_point[2] + k)};
      hn::StoreU(Dot(query_.along, v), d, cut.along + k);
      hn::StoreU(Dot(query_.up, v), d, cut.up + k);
    }
    for (; hit != 0; hit &= hit - 1) {
      // One corner is alone on its side of the plane; the plane itself belongs to one side.
      static constexpr uint8_t kAlone[8][3] = {{0, 1, 2}, {0, 1, 2}, {1, 0, 2}, {2, 0, 1},
                                               {2, 0, 1}, {1, 0, 2}, {0, 1, 2}, {0, 1, 2}};
      const auto& corners = header.corners[size_t(__builtin_ctzll(hit))];
      const uint32_t sides = (cut.over_plane >> corners[0] & 1) | (cut.over_plane >> corners[1] & 1) << 1 |
                             (cut.over_plane >> corners[2] & 1) << 2;
      const auto& order = kAlone[sides];
      AddSection(cut, corners[order[0]], corners[order[1]], corners[order[2]]);
    }
  }

  /// The edges from corner a, which is alone, to b and c, as sums of positive terms.
  HWY_INLINE void AddSection(const CutVertices& cut, size_t a, size_t b, size_t c) {
    const double away_a = std::abs(cut.side[a]), away_b = std::abs(cut.side[b]),
                 away_c = std::abs(cut.side[c]);
    const size_t n = waiting_++;
    ends_[0].along[n] = away_b * cut.along[a] + away_a * cut.along[b];
    ends_[0].up[n] = away_b * cut.up[a] + away_a * cut.up[b];
    ends_[0].weight[n] = away_a + away_b;
    ends_[1].along[n] = away_c * cut.along[a] + away_a * cut.along[c];
    ends_[1].up[n] = away_c * cut.up[a] + away_a * cut.up[c];
    ends_[1].weight[n] = away_a + away_c;
    if (waiting_ == kTreeWidth) AddWaiting();
  }

  /// Adds the sections that have been put off.
  HWY_INLINE void AddWaiting() {
    const Doubles d;
    HWY_ALIGN double position[2][kTreeWidth];
    uint64_t plain = 0;  // Those of which nothing is to be cut off.
    for (size_t i = 0; segments_.OnlyCovers() && i < waiting_; i += hn::Lanes(d)) {
      uint64_t bits = ~uint64_t{0};
      for (size_t e = 0; e < 2; ++e) {
        const DoublesV along = hn::Load(d, ends_[e].along + i), up = hn::Load(d, ends_[e].up + i);
        const DoublesV weight = hn::Load(d, ends_[e].weight + i);
        const DoublesV square = hn::Add(hn::Mul(along, along), hn::Mul(up, up));
        const DoublesV height =
            hn::Add(hn::Mul(hn::Set(d, query_.face_along), along), hn::Mul(hn::Set(d, query_.face_up), up));
        const DoublesV zero = hn::Zero(d), least = hn::Set(d, segments_.least());
        const auto is_plain = hn::And(hn::And(hn::Gt(up, zero), hn::Gt(height, zero)),
                                      hn::Gt(square, hn::Mul(hn::Mul(least, weight), weight)));
        bits &= BitsOf(d, is_plain);
        const DoublesV l = hn::Div(along, hn::Sqrt(square));
        hn::Store(hn::Add(hn::Mul(l, hn::Set(d, kLineEnd)), hn::Set(d, kRounder)), d, position[e] + i);
      }
      plain |= bits << i;
    }
    for (size_t i = 0; i < waiting_; ++i) {
      if ((plain >> i & 1) != 0) {
        segments_.AddCover(PositionFrom(position[0][i]), PositionFrom(position[1][i]));
      } else {
        segments_.Add({ends_[0].along[i], ends_[0].up[i], ends_[0].weight[i], ends_[1].along[i],
                       ends_[1].up[i], ends_[1].weight[i]});
      }
    }
    waiting_ = 0;
  }

  const OccluderTree& tree_;
  const LineQuery& query_;
  LineSegments& segments_;
  float point_[3], along_[3], up_[3], plane_[3], face_[3];
  float slack_, reach_;
  struct SectionEnds {
    HWY_ALIGN double along[kTreeWidth], up[kTreeWidth], weight[kTreeWidth];
  };
  SectionEnds ends_[2] = {};
  size_t waiting_ = 0;
  Entry stack_[kMostEntries];
};

HWY_ATTR void WalkLineKernel(const OccluderTree& tree, const LineQuery& query, LineSegments& segments) {
  Walker(tree, query, segments).Run();
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
