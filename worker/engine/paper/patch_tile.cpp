#include "worker/engine/paper/patch_tile.h"

#include <algorithm>
#include <cmath>

#include "common/math/tolerance.h"
#include "worker/engine/paper/barycentric.h"

namespace shutterline::engine::paper {

PatchTile::PatchTile(const LinePattern& pattern, const TileTriangles& tile, const Options& options,
                     PairWeights& weights, RenderStats& stats)
    : pattern_(pattern),
      tile_(tile),
      weights_(weights),
      stats_(stats),
      line_(pattern, tile, options, stats),
      cell_resolver_(options) {}

void PatchTile::Resolve() {
  // Neighbouring lines share one scan over the tile's triangles.
  constexpr size_t kLinesPerGroup = 8;
  const std::vector<TileLine> lines = pattern_.LinesIn(tile_.rect);
  for (size_t i = 0; i < lines.size();) {
    size_t end = i + 1;
    while (end < lines.size() && end - i < kLinesPerGroup && lines[end].family == lines[i].family) ++end;
    const auto family = size_t(lines[i].family);
    candidates_.clear();
    for (uint32_t k = 0; k < tile_.triangles.size(); ++k) {
      const TileTriangle& triangle = tile_.triangles[k];
      if (triangle.first_line[family] <= lines[end - 1].number &&
          triangle.last_line[family] >= lines[i].number) {
        candidates_.push_back(k);
      }
    }
    if (!candidates_.empty()) {
      for (; i < end; ++i) ResolveLine(lines[i]);
    }
    i = end;
  }
}

void PatchTile::ResolveLine(const TileLine& line) {
  ++stats_.lines;
  tile_line_ = &line;
  line_.Gather(line, candidates_);
  if (!line_.moves()) {
    ++stats_.instants;
    AddStillLine();
    return;
  }
  const int rows = line_.cells().time_cells();
  stats_.instants += rows;
  for (int row = 0; row < rows; ++row) {
    for (int step = line.first_step; step < line.end_step; ++step) ResolveCell(step, row);
  }
}

/// The integer weight of a row of cells: rows telescope to the whole shutter's.
uint64_t PatchTile::RowWeight(int row) const {
  const auto rows = uint64_t(line_.cells().time_cells());
  const auto r = uint64_t(row);
  return kShutterWeight * (r + 1) / rows - kShutterWeight * r / rows;
}

void PatchTile::AddStillLine() {
  for (const VisibleSpan& span : line_.still().spans()) {
    for (int32_t from = span.begin; from < span.end;) {
      const int32_t to = std::min(span.end, ((from >> kSubpixelBits) + 1) << kSubpixelBits);
      AddStillSpan(span, from, to, kShutterWeight, 0);
      from = to;
    }
  }
}

void PatchTile::AddStillCell(int step, uint64_t weight, double t) {
  const int32_t begin = step << kSubpixelBits;
  const int32_t end = (step + 1) << kSubpixelBits;
  const auto& spans = line_.still().spans();
  auto span = std::lower_bound(spans.begin(), spans.end(), begin,
                               [](const VisibleSpan& s, int32_t at) { return s.end <= at; });
  for (; span != spans.end() && span->begin < end; ++span) {
    AddStillSpan(*span, std::max(begin, span->begin), std::min(end, span->end), weight, t);
  }
}

/// The part [begin, end), within one pixel, of a span of something that stands still.
void PatchTile::AddStillSpan(const VisibleSpan& span, int32_t begin, int32_t end, uint64_t weight, double t) {
  const LineSegment& segment = line_.still().segments()[span.segment];
  const TileTriangle& triangle = tile_.triangles[segment.index];
  ++stats_.spans;
  PixelPair piece{.triangle = segment.id,
                  .bin = uint16_t(t * double(1u << triangle.shading_bins_log2)),
                  .bins_log2 = triangle.shading_bins_log2,
                  .weight = uint64_t(end - begin) * weight};
  if (triangle.needs_position) {
    const double middle = (double(begin) + double(end)) * (0.5 / kSubpixelsPerPixel);
    const SegmentBarycentric at = BarycentricAt(segment, line_.still().positions()[span.segment], middle);
    piece.b1 = at.b1;
    piece.b2 = at.b2;
  }
  weights_.Add(PixelOf(begin >> kSubpixelBits), piece);
}

bool PatchTile::AllStill() const {
  return std::none_of(cell_pieces_.begin(), cell_pieces_.end(),
                      [&](uint32_t p) { return tile_.triangles[line_.pieces()[p].index].moves; });
}

void PatchTile::ResolveCell(int step, int row) {
  const CellGrid& cells = line_.cells();
  cells.Collect(step, row, cell_pieces_);
  if (cell_pieces_.empty()) return;
  const CellBounds cell{double(step), cells.TimeOf(row), cells.TimeOf(row + 1)};
  if (AllStill()) {
    AddStillCell(step, RowWeight(row), 0.5 * (cell.t0 + cell.t1));
    return;
  }
  cell_resolver_.Resolve(cell, cell_pieces_, line_.pieces());

  double covered = 0;
  for (const VisibleFragment& fragment : cell_resolver_.fragments()) covered += fragment.area;
  stats_.spans += int64_t(cell_resolver_.fragments().size());
  if (!(covered > 0)) return;
  const auto total = double(uint64_t{kSubpixelsPerPixel} * RowWeight(row));
  const double scale = covered >= 1 - kCellSliver ? total / covered : total;
  double sum = 0;
  uint64_t given = 0;
  for (size_t i = 0; i < cell_resolver_.fragments().size(); ++i) {
    const VisibleFragment& fragment = cell_resolver_.fragments()[i];
    sum += fragment.area;
    const auto up_to = uint64_t(std::min(std::floor(sum * scale + 0.5), total));
    if (up_to > given) AddFragment(step, cell, fragment, up_to - given);
    given = up_to;
  }
}

void PatchTile::AddFragment(int step, const CellBounds& cell, const VisibleFragment& fragment,
                            uint64_t weight) {
  const TileTriangle& triangle = tile_.triangles[fragment.index];
  const double t = std::clamp(cell.t0 + fragment.v * (cell.t1 - cell.t0), 0.0, 1 - 0x1p-53);
  PixelPair piece{.triangle = triangle.id,
                  .bin = uint16_t(t * double(1u << triangle.shading_bins_log2)),
                  .bins_log2 = triangle.shading_bins_log2,
                  .weight = weight};
  if (triangle.needs_position) {
    const SegmentBarycentric at = BarycentricOf(triangle, line_.line(), cell.l0 + fragment.u, t);
    piece.b1 = at.b1;
    piece.b2 = at.b2;
  }
  weights_.Add(PixelOf(step), piece);
}

int64_t PatchTile::PixelOf(int step) const {
  const int minor = pattern_.MinorPixel(*tile_line_, step);
  return line_.line().major_is_x ? int64_t{minor} * tile_.rect.width + step
                                 : int64_t{step} * tile_.rect.width + minor;
}

}  // namespace shutterline::engine::paper
