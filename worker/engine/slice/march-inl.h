// Visibility along lines in lockstep. Included once per instruction set, by kernels.cpp.
#if defined(SHUTTERLINE_SLICE_MARCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_SLICE_MARCH_INL_H
#undef SHUTTERLINE_SLICE_MARCH_INL_H
#else
#define SHUTTERLINE_SLICE_MARCH_INL_H
#endif

#include <hwy/highway.h>

#include <limits>

#include "worker/engine/slice/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Marches the lanes [base, base + Lanes) of a group.
class Marcher {
 public:
  using Ints = hn::CappedTag<int32_t, kLanes>;
  using Floats = hn::Rebind<float, Ints>;
  using Ids = hn::Rebind<uint32_t, Ints>;
  using IntsV = hn::Vec<Ints>;
  using FloatsV = hn::Vec<Floats>;
  using Mask = hn::Mask<Ints>;
  using FloatMask = hn::Mask<Floats>;

  HWY_INLINE Marcher(const SegmentLists& lists, const uint32_t* ids, int base)
      : begin_(lists.begin.data()),
        end_(lists.end.data()),
        depth_(lists.depth.data()),
        slope_(lists.slope.data()),
        index_(reinterpret_cast<const int32_t*>(lists.index.data())),
        ids_(reinterpret_cast<const int32_t*>(ids)),
        rows_(lists.rows),
        base_(base),
        lane_(hn::Iota(Ints(), base)) {}

  /// Marches the lanes from x to their limits; writes row after row of `pieces` and returns their number.
  HWY_INLINE int32_t Run(IntsV x, IntsV limit, VisiblePieces& pieces) {
    const Ints di;
    const Floats df;
    const auto none = hn::Set(di, -1);
    const auto lowest = hn::Set(df, -std::numeric_limits<float>::infinity());
    const auto steepest = hn::Set(df, std::numeric_limits<float>::infinity());

    // In the beginning nothing is in front, and that ends where the lane begins: such a segment loses every
    // comparison and is never overtaken.
    Segment current{x, x, lowest, steepest, none};
    auto finished = AtLeast(x, limit);
    int32_t written = 0;
    while (!hn::AllTrue(di, finished)) {
      const auto end = hn::Min(current.end, limit);
      Change change{end, none};            // What becomes visible before the current one ends.
      Candidate after{end, lowest, none};  // The nearest there where it ends.
      Candidate gap{limit, lowest, none};  // The first that begins later.
      for (int32_t r = 0; r < rows_; ++r) Visit(r, x, end, current, change, after, gap);

      pieces.Reserve(written);
      const size_t at = size_t(written++) * kLanes + size_t(base_);
      const auto shows = AtLeast(current.entry, hn::Zero(di));
      hn::StoreU(x, di, pieces.begin.data() + at);
      hn::StoreU(hn::IfThenElse(shows, change.at, x), di, pieces.end.data() + at);
      hn::StoreU(current.entry, di, pieces.entry.data() + at);

      const auto changes = AtLeast(change.entry, hn::Zero(di));
      const auto continues = AtLeast(after.entry, hn::Zero(di));
      x = hn::IfThenElse(changes, change.at, hn::IfThenElse(continues, end, gap.at));
      auto next = hn::IfThenElse(changes, change.entry, hn::IfThenElse(continues, after.entry, gap.entry));
      finished = hn::Or(AtLeast(x, limit), hn::Lt(next, hn::Zero(di)));
      x = hn::IfThenElse(finished, limit, x);
      next = hn::IfThenElse(finished, none, next);
      current = Fetch(next, x, finished);
    }
    return written;
  }

 private:
  struct Segment {
    IntsV begin, end;
    FloatsV depth, slope;
    IntsV entry;
  };
  struct Change {
    IntsV at, entry;
  };
  struct Candidate {
    IntsV at;
    FloatsV depth;
    IntsV entry;
  };

  static HWY_INLINE FloatsV DepthAt(FloatsV depth, FloatsV slope, IntsV from, IntsV at) {
    return hn::Add(depth, hn::Mul(slope, hn::ConvertTo(Floats(), hn::Sub(at, from))));
  }
  /// a >= b, which not every instruction set has.
  static HWY_INLINE Mask AtLeast(IntsV a, IntsV b) { return hn::Not(hn::Lt(a, b)); }
  static HWY_INLINE FloatMask F(Mask m) { return hn::RebindMask(Floats(), m); }
  static HWY_INLINE Mask I(FloatMask m) { return hn::RebindMask(Ints(), m); }

  HWY_INLINE IntsV AddressOf(IntsV entry) const {
    return hn::Add(hn::ShiftLeft<4>(hn::Max(entry, hn::Zero(Ints()))), lane_);
  }

  HWY_INLINE Segment Fetch(IntsV entry, IntsV x, Mask finished) const {
    const Ints di;
    const Floats df;
    const auto at = AddressOf(entry);
    Segment s{hn::GatherIndex(di, begin_, at), hn::GatherIndex(di, end_, at), hn::GatherIndex(df, depth_, at),
              hn::GatherIndex(df, slope_, at), entry};
    s.begin = hn::IfThenElse(finished, x, s.begin);
    s.end = hn::IfThenElse(finished, x, s.end);
    s.depth = hn::IfThenElse(F(finished), hn::Set(df, -std::numeric_limits<float>::infinity()), s.depth);
    s.slope = hn::IfThenElse(F(finished), hn::Set(df, std::numeric_limits<float>::infinity()), s.slope);
    return s;
  }

  /// At equal depths: does entry `r` of slope `slope` hide entry `other` right of there? The faster rising
  /// does, then the lower id.
  HWY_NOINLINE Mask WinsTie(int32_t r, FloatsV slope, IntsV other) const {
    const Ints di;
    const Ids du;
    const auto at = AddressOf(other);
    const auto other_slope = hn::GatherIndex(Floats(), slope_, at);
    const auto other_id = hn::BitCast(du, hn::GatherIndex(di, ids_, hn::GatherIndex(di, index_, at)));
    const auto own = hn::LoadU(di, index_ + size_t(r) * kLanes + size_t(base_));
    const auto lower = hn::RebindMask(di, hn::Lt(hn::BitCast(du, hn::GatherIndex(di, ids_, own)), other_id));
    return hn::Or(I(hn::Gt(slope, other_slope)), hn::And(I(hn::Eq(slope, other_slope)), lower));
  }

  HWY_INLINE void Visit(int32_t r, IntsV x, IntsV end, const Segment& current, Change& change,
                        Candidate& after, Candidate& gap) const {
    const Ints di;
    const Floats df;
    const size_t at = size_t(r) * kLanes + size_t(base_);
    const auto b = hn::LoadU(di, begin_ + at);
    const auto e = hn::LoadU(di, end_ + at);
    // Most entries have been passed on all lanes, or begin too far ahead to matter yet: neither before the
    // current piece ends nor as soon as anything known that begins later.
    const auto matters = hn::And(hn::Gt(e, x), AtLeast(hn::Max(end, gap.at), b));
    if (hn::AllFalse(di, matters)) return;
    const auto depth = hn::LoadU(df, depth_ + at);
    const auto slope = hn::LoadU(df, slope_ + at);
    const auto entry = hn::Set(di, r);

    // Where the current one ends, or this one before.
    const auto probe = hn::Min(e, end);
    const auto depth_probe = DepthAt(depth, slope, b, probe);
    const auto current_probe = DepthAt(current.depth, current.slope, current.begin, probe);

    const auto begun = AtLeast(end, b);
    const auto there = hn::And(begun, hn::Gt(e, end));
    auto nearer = hn::And(there, I(hn::Gt(depth_probe, after.depth)));
    const auto tie = hn::And(there, I(hn::Eq(depth_probe, after.depth)));
    if (!hn::AllFalse(di, tie)) nearer = hn::Or(nearer, hn::And(tie, WinsTie(r, slope, after.entry)));
    after.depth = hn::IfThenElse(F(nearer), depth_probe, after.depth);
    after.entry = hn::IfThenElse(nearer, entry, after.entry);

    auto sooner = hn::AndNot(begun, hn::Lt(b, gap.at));
    const auto as_soon = hn::AndNot(begun, hn::And(hn::Eq(b, gap.at), AtLeast(gap.entry, hn::Zero(di))));
    if (!hn::AllFalse(di, as_soon)) {
      const auto equal = hn::And(I(hn::Eq(depth, gap.depth)), WinsTie(r, slope, gap.entry));
      sooner = hn::Or(sooner, hn::And(as_soon, hn::Or(I(hn::Gt(depth, gap.depth)), equal)));
    }
    gap.at = hn::IfThenElse(sooner, b, gap.at);
    gap.depth = hn::IfThenElse(F(sooner), depth, gap.depth);
    gap.entry = hn::IfThenElse(sooner, entry, gap.entry);

    // Begins in front of the current one.
    const auto begins = hn::Gt(b, x);
    const auto current_begin = DepthAt(current.depth, current.slope, current.begin, b);
    const auto within = hn::And(hn::Lt(b, change.at), hn::Gt(e, x));
    const auto in_front = hn::And(hn::And(within, begins), I(hn::Gt(depth, current_begin)));
    const auto overtakes = hn::AndNot(
        in_front,
        hn::And(within, I(hn::And(hn::Gt(slope, current.slope), hn::Gt(depth_probe, current_probe)))));
    // Rare: comes in front at the same place as another, overtakes, or lies at the very same depth.
    const auto rare = hn::Or(
        overtakes, hn::And(begins, hn::Or(hn::And(hn::Eq(b, change.at), AtLeast(change.entry, hn::Zero(di))),
                                          hn::And(within, I(hn::And(hn::Eq(depth, current_begin),
                                                                    hn::Ge(slope, current.slope)))))));
    change.at = hn::IfThenElse(in_front, b, change.at);
    change.entry = hn::IfThenElse(in_front, entry, change.entry);
    if (!hn::AllFalse(di, rare)) Rare(r, x, end, current, overtakes, b, e, depth, slope, change);
  }

  /// The changes that need more than a comparison.
  HWY_NOINLINE void Rare(int32_t r, IntsV x, IntsV end, const Segment& current, Mask overtakes, IntsV b,
                         IntsV e, FloatsV depth, FloatsV slope, Change& change) const {
    const Ints di;
    const Floats df;
    // Where it overtakes: both are linear from where both are there. At least one subpixel on, so that the
    // march cannot stand still.
    const auto from = hn::Max(b, x);
    const auto lead =
        hn::Sub(DepthAt(current.depth, current.slope, current.begin, from), DepthAt(depth, slope, b, from));
    const auto run = hn::Div(lead, hn::Sub(slope, current.slope));
    const auto longest = hn::Set(df, float(SegmentLists::kNeverBegins));
    const auto steps = hn::ConvertTo(di, hn::Ceil(hn::Min(hn::Max(run, hn::Zero(df)), longest)));
    const auto overtakes_at = hn::Max(hn::Add(from, steps), hn::Add(x, hn::Set(di, 1)));

    const auto current_begin = DepthAt(current.depth, current.slope, current.begin, b);
    const auto begins = hn::And(hn::Gt(b, x), hn::Lt(b, end));
    const auto equal = hn::And(I(hn::Eq(depth, current_begin)), WinsTie(r, slope, current.entry));
    const auto starts = hn::And(begins, hn::Or(I(hn::Gt(depth, current_begin)), equal));
    const auto comes = hn::Or(starts, overtakes);
    const auto at = hn::IfThenElse(starts, b, overtakes_at);
    const auto before = hn::And(comes, hn::And(hn::Lt(at, end), hn::Lt(at, e)));

    auto better = hn::And(before, hn::Lt(at, change.at));
    const auto same = hn::And(before, hn::And(hn::Eq(at, change.at), AtLeast(change.entry, hn::Zero(di))));
    const auto rival = Fetch(change.entry, x, hn::Lt(change.entry, hn::Zero(di)));
    const auto depth_here = DepthAt(depth, slope, b, at);
    const auto depth_rival = DepthAt(rival.depth, rival.slope, rival.begin, at);
    const auto nearer = hn::Or(I(hn::Gt(depth_here, depth_rival)),
                               hn::And(I(hn::Eq(depth_here, depth_rival)), WinsTie(r, slope, change.entry)));
    better = hn::Or(better, hn::And(same, nearer));
    change.at = hn::IfThenElse(better, at, change.at);
    change.entry = hn::IfThenElse(better, hn::Set(di, r), change.entry);
  }

  // The lists, as they are when the march begins.
  const int32_t* begin_;
  const int32_t* end_;
  const float* depth_;
  const float* slope_;
  const int32_t* index_;
  const int32_t* ids_;
  int32_t rows_;
  int base_;
  IntsV lane_;
};

inline void MarchKernel(const SegmentLists& lists, const uint32_t* ids, const LineGroup& group,
                        uint32_t active, VisiblePieces& pieces) {
  const Marcher::Ints di;
  const int n = int(hn::Lanes(di));
  int32_t rows = 0;
  alignas(64) int32_t begin[kLanes], end[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) {
    const bool wanted = (active >> lane & 1) != 0 && lists.count[size_t(lane)] > 0;
    begin[lane] = std::max(group.begin[size_t(lane)], lists.stretch_begin);
    end[lane] = wanted ? std::min(group.end[size_t(lane)], lists.stretch_end) : begin[lane];
  }
  // Vectors that end early leave rows of the others open: empty ones are filled in.
  int32_t written[kLanes];
  int vectors = 0;
  for (int base = 0; base < kLanes; base += n) {
    Marcher marcher(lists, ids, base);
    written[vectors] = marcher.Run(hn::LoadU(di, begin + base), hn::LoadU(di, end + base), pieces);
    rows = std::max(rows, written[vectors++]);
  }
  for (int v = 0; v < vectors; ++v) {
    for (int32_t r = written[v]; r < rows; ++r) {
      const size_t at = size_t(r) * kLanes + size_t(v * n);
      hn::StoreU(hn::Zero(di), di, pieces.begin.data() + at);
      hn::StoreU(hn::Zero(di), di, pieces.end.data() + at);
    }
  }
  pieces.rows = rows;
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
