#include "worker/engine/paper/cell_grid.h"

#include <algorithm>
#include <cmath>

#include "common/math/tolerance.h"

namespace shutterline::engine::paper {
namespace {

/// A slab's side at time t.
double SideAt(double at0, double at1, const Slab& slab, double t) {
  if (t <= slab.t0) return at0;
  if (t >= slab.t1) return at1;
  return at0 + (t - slab.t0) / (slab.t1 - slab.t0) * (at1 - at0);
}

}  // namespace

void CellGrid::Begin(int first_step, int end_step, int time_cells) {
  first_step_ = first_step;
  steps_ = end_step - first_step;
  time_cells_ = time_cells;
  cells_.assign(size_t(steps_) * size_t(time_cells), {});
  entries_.clear();
  cover_changed_ = false;
  hidden_below_ = -std::numeric_limits<double>::infinity();
}

void CellGrid::Add(std::span<const PatchPiece> pieces, uint32_t first) {
  if (pieces.empty()) return;
  const int first_row = std::clamp(int(pieces.front().slab.t0 * time_cells_), 0, time_cells_ - 1);
  const int last_row = std::clamp(int(pieces.back().slab.t1 * time_cells_), 0, time_cells_ - 1);
  size_t begin = 0;
  for (int row = first_row; row <= last_row; ++row) {
    while (begin < pieces.size() && pieces[begin].slab.t1 <= TimeOf(row)) ++begin;
    size_t end = begin;
    while (end < pieces.size() && pieces[end].slab.t0 < TimeOf(row + 1)) ++end;
    if (begin < end) AddRow(row, pieces.subspan(begin, end - begin), first + uint32_t(begin));
  }
}

void CellGrid::AddRow(int row, std::span<const PatchPiece> pieces, uint32_t first_piece) {
  const double row_begin = TimeOf(row);
  const double row_end = TimeOf(row + 1);
  // The stretch of the line that the patch covers during all of the row, and how much of the row that is.
  double covered_from = first_step_;
  double covered_to = first_step_ + steps_;
  double covered_time = 0;
  farthest_.assign(size_t(steps_), std::numeric_limits<double>::infinity());

  for (size_t i = 0; i < pieces.size(); ++i) {
    const Slab& slab = pieces[i].slab;
    const double t0 = std::max(row_begin, slab.t0);
    const double t1 = std::min(row_end, slab.t1);
    const double left0 = SideAt(slab.left0, slab.left1, slab, t0);
    const double left1 = SideAt(slab.left0, slab.left1, slab, t1);
    const double right0 = SideAt(slab.right0, slab.right1, slab, t0);
    const double right1 = SideAt(slab.right0, slab.right1, slab, t1);
    covered_time += t1 - t0;
    covered_from = std::max({covered_from, left0, left1});
    covered_to = std::min({covered_to, right0, right1});

    // Sides cut at the row's borders are rounded: a pixel's thousandth more costs nothing.
    const double from = std::min(left0, left1) - 1e-3;
    const double to = std::max(right0, right1) + 1e-3;
    const double end_step = first_step_ + steps_;
    const int first = int(std::floor(std::clamp(from, double(first_step_), end_step)));
    const int end = int(std::ceil(std::clamp(to, double(first_step_), end_step)));
    BinPiece(first_piece + uint32_t(i), pieces[i], row, first, end);
  }

  // Only without a gap in time, and up to rounding none that a cell could show.
  if (std::abs(covered_time - (row_end - row_begin)) > kOnLine * (row_end - row_begin)) return;
  const int first = int(std::ceil(covered_from));
  const int end = int(std::floor(covered_to));
  for (int step = first; step < end; ++step) {
    Cell& cell = At(step, row);
    const double farthest = farthest_[size_t(step - first_step_)];
    if (farthest > cell.hidden_below) {
      cell.hidden_below = farthest;
      cover_changed_ = true;
    }
  }
}

void CellGrid::BinPiece(uint32_t number, const PatchPiece& piece, int row, int first, int end) {
  const double t0 = std::max(TimeOf(row), piece.slab.t0);
  const double t1 = std::min(TimeOf(row + 1), piece.slab.t1);
  for (int step = first; step < end; ++step) {
    const DepthRange range = piece.RangeOver(step, step + 1, t0, t1);
    double& farthest = farthest_[size_t(step - first_step_)];
    farthest = std::min(farthest, range.farthest);
    Cell& cell = At(step, row);
    const double nearest = range.nearest * kDepthSlack;
    if (nearest < cell.hidden_below) continue;
    entries_.push_back({number, cell.head, nearest});
    cell.head = uint32_t(entries_.size() - 1);
  }
}

double CellGrid::HiddenBelow() {
  if (cover_changed_) {
    hidden_below_ = std::numeric_limits<double>::infinity();
    for (const Cell& cell : cells_) hidden_below_ = std::min(hidden_below_, cell.hidden_below);
    cover_changed_ = false;
  }
  return hidden_below_;
}

void CellGrid::Collect(int step, int row, std::vector<uint32_t>& pieces) const {
  pieces.clear();
  const Cell& cell = At(step, row);
  for (uint32_t i = cell.head; i != kNone; i = entries_[i].next) {
    if (entries_[i].nearest >= cell.hidden_below) pieces.push_back(entries_[i].piece);
  }
}

}  // namespace shutterline::engine::paper
