#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "worker/engine/paper/patch_piece.h"

namespace shutterline::engine::paper {

/// The m × n lt-cells of one line, m its pixels and n spans of the shutter: which patch pieces may be seen
/// in which cell [gribel2011, section 5.1].
///
/// Binning is conservative. A triangle whose patch covers a cell hides in it whatever lies behind its
/// farthest depth there (Z_max^cell of the paper; ours is a nearness, so a minimum). Cover is tested against
/// the sides of the whole patch, as a single patch triangle seldom covers a cell. What came before
/// its occluder (Z_min^cell) is dropped when the cell is read.
///
/// Keeps its memory between lines; one object per thread.
class CellGrid {
 public:
  /// Begins a line whose pixels are [first_step, end_step) with nothing in its cells.
  void Begin(int first_step, int end_step, int time_cells);

  /// Bins one triangle's pieces, ascending in time and disjoint; the first of them is number `first`. Appends
  /// what is not hidden already to the cells' lists.
  void Add(std::span<const PatchPiece> pieces, uint32_t first);

  /// Depths below this are hidden in every cell; minus infinity where a cell is not covered.
  double HiddenBelow();

  int time_cells() const { return time_cells_; }
  double TimeOf(int row) const { return row == time_cells_ ? 1 : double(row) / time_cells_; }

  /// Replaces `pieces` by those that may be seen in a cell.
  void Collect(int step, int row, std::vector<uint32_t>& pieces) const;

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};
  struct Entry {
    uint32_t piece;
    uint32_t next;
    double nearest;
  };
  struct Cell {
    uint32_t head = kNone;
    double hidden_below = -std::numeric_limits<double>::infinity();
  };

  void AddRow(int row, std::span<const PatchPiece> pieces, uint32_t first);
  void BinPiece(uint32_t number, const PatchPiece& piece, int row, int first, int end);
  Cell& At(int step, int row) { return cells_[size_t(row) * size_t(steps_) + size_t(step - first_step_)]; }
  const Cell& At(int step, int row) const {
    return cells_[size_t(row) * size_t(steps_) + size_t(step - first_step_)];
  }

  int first_step_ = 0, steps_ = 0, time_cells_ = 1;
  std::vector<Cell> cells_;
  std::vector<Entry> entries_;
  std::vector<double> farthest_;  // By step: of the triangle being added, in its row.
  bool cover_changed_ = false;
  double hidden_below_ = 0;
};

}  // namespace shutterline::engine::paper
