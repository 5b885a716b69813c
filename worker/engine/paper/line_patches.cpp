#include "worker/engine/paper/line_patches.h"

#include "common/math/tolerance.h"

namespace shutterline::engine::paper {

void LinePatches::Gather(const TileLine& line, std::span<const uint32_t> candidates) {
  family_ = line.family;
  number_ = line.number;
  first_step_ = line.first_step;
  end_step_ = line.end_step;
  line_ = MakeSegmentLine(pattern_, line);
  patch_.Begin(line_, options_);
  pieces_.clear();
  moves_ = false;
  ResolveStill(candidates);
  for (const uint32_t index : candidates) {
    const TileTriangle& triangle = tile_.triangles[index];
    if (!still_.Wants(triangle.nearest_depth)) break;
    if (!triangle.moves || !Touches(triangle)) continue;
    // All that follows is no nearer: where every cell is covered, the rest of the list is hidden.
    if (moves_ && triangle.nearest_depth < cells_.HiddenBelow()) break;
    BinMoving(index);
  }
}

void LinePatches::ResolveStill(std::span<const uint32_t> candidates) {
  still_.Begin(line_.begin, line_.end);
  for (const uint32_t index : candidates) {
    const TileTriangle& triangle = tile_.triangles[index];
    if (!still_.Wants(triangle.nearest_depth)) break;
    if (triangle.moves || !Touches(triangle)) continue;
    LineSegment segment;
    SegmentPosition position;
    if (!MakeSegment(triangle, index, tile_.far_depth, line_, 0, &segment,
                     triangle.needs_position ? &position : nullptr)) {
      continue;
    }
    ++stats_.segments;
    still_.Offer(segment, position);
  }
  still_.Finish();
}

void LinePatches::BinMoving(uint32_t index) {
  const TileTriangle& triangle = tile_.triangles[index];
  patch_.Make(triangle, tile_.far_depth);
  const auto first = uint32_t(pieces_.size());
  const auto low = double(first_step_);
  const auto high = double(end_step_);
  for (const Slab& slab : patch_.slabs()) {
    if (std::max(slab.right0, slab.right1) <= low || std::min(slab.left0, slab.left1) >= high) continue;
    pieces_.emplace_back(slab, index, triangle.id);
  }
  if (pieces_.size() == first) return;
  if (!moves_) {
    moves_ = true;
    cells_.Begin(first_step_, end_step_, options_.time_cells);
    const auto still = uint32_t(pieces_.size());
    BinStill();
    // The grid takes one triangle's pieces at a time, in any order of triangles.
    stats_.segments += int64_t(pieces_.size() - still);
    cells_.Add(std::span(pieces_).subspan(first, still - first), first);
    return;
  }
  stats_.segments += int64_t(pieces_.size() - first);
  cells_.Add(std::span(pieces_).subspan(first), first);
}

/// The first moving patch brings what stands still along.
void LinePatches::BinStill() {
  for (const VisibleSpan& span : still_.spans()) {
    const LineSegment& segment = still_.segments()[span.segment];
    const double l0 = double(span.begin) / kSubpixelsPerPixel;
    const double l1 = double(span.end) / kSubpixelsPerPixel;
    const Slab slab = DepthPatch::Static(l0, l1, segment.DepthAt(l0), segment.DepthAt(l1));
    pieces_.emplace_back(slab, segment.index, segment.id);
    const auto number = uint32_t(pieces_.size() - 1);
    cells_.Add(std::span(pieces_).subspan(number), number);
  }
}

std::optional<PatchSight> LinePatches::SeeAt(double l, double t) const {
  std::optional<PatchSight> best;
  uint32_t best_id = 0;
  const auto offer = [&](uint32_t id, double depth) {
    if (best && (depth < best->depth || (depth == best->depth && id > best_id))) return;
    best = PatchSight{id, depth};
    best_id = id;
  };
  if (!moves_) {
    for (const VisibleSpan& span : still_.spans()) {
      const LineSegment& segment = still_.segments()[span.segment];
      if (l * kSubpixelsPerPixel >= span.begin && l * kSubpixelsPerPixel < span.end) {
        offer(segment.id, segment.DepthAt(l));
      }
    }
    return best;
  }
  for (const PatchPiece& piece : pieces_) {
    const Slab& slab = piece.slab;
    if (t < slab.t0 || t >= slab.t1) continue;
    const double s = (t - slab.t0) / (slab.t1 - slab.t0);
    const bool inside =
        l >= slab.left0 + s * (slab.left1 - slab.left0) && l < slab.right0 + s * (slab.right1 - slab.right0);
    if (inside) offer(piece.id, piece.DepthAt(l, t));
  }
  return best;
}

}  // namespace shutterline::engine::paper
