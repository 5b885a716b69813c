#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "worker/engine/slice/line_class.h"

namespace shutterline::engine {

/// For each lane a depth below which nothing can be seen on a stretch, and the least of them.
struct HiddenBelow {
  std::array<float, kLanes> lanes{};
  float all = 0;

  void UpdateAll() { all = *std::min_element(lanes.begin(), lanes.end()); }
};

/// For each lane the segments that reach into a stretch of the lines: entry n of lane i is at
/// [n · kLanes + i]. Lanes that have fewer entries than others are filled up with segments that cover
/// nothing. Lists grow as needed.
///
/// Depth at subpixel x of a segment is depth + slope · (x − begin).
struct SegmentLists {
  static constexpr int32_t kNeverBegins = 1 << 30;

  /// The stretch, subpixels; lanes' own ends cut it further.
  int32_t stretch_begin = 0, stretch_end = 0;
  int32_t rows = 0;        ///< The longest list.
  int32_t compact_at = 0;  ///< When `rows` reaches this, what is hidden should be dropped.
  uint32_t touched = 0;    ///< A bit for each lane that something has been appended to since Clear.
  std::array<int32_t, kLanes> count{};
  std::vector<int32_t> begin, end;
  std::vector<float> depth, slope;
  std::vector<uint32_t> index;  ///< Of the triangle in the tile's mesh.

  void Clear() {
    rows = 0;
    touched = 0;
    count.fill(0);
  }

  /// Begins with the rows of another.
  void StartFrom(const SegmentLists& other) {
    rows = other.rows;
    count = other.count;
    const size_t n = size_t(rows) * kLanes;
    if (begin.size() < n) Grow(n);
    std::copy_n(other.begin.data(), n, begin.data());
    std::copy_n(other.end.data(), n, end.data());
    std::copy_n(other.depth.data(), n, depth.data());
    std::copy_n(other.slope.data(), n, slope.data());
    std::copy_n(other.index.data(), n, index.data());
  }

  /// Forgets what came after the first `kept` rows. What is appended next begins below them on all lanes.
  void Truncate(int32_t kept) {
    rows = kept;
    touched = 0;
    count.fill(kept);
  }

  void Append(int lane, int32_t b, int32_t e, float d, float s, uint32_t tile_index) {
    touched |= uint32_t{1} << lane;
    const int32_t n = count[size_t(lane)]++;
    if (n == rows) AddRow();
    const size_t at = size_t(n) * kLanes + size_t(lane);
    begin[at] = b;
    end[at] = e;
    depth[at] = d;
    slope[at] = s;
    index[at] = tile_index;
  }

 private:
  void Grow(size_t n) {
    begin.resize(n);
    end.resize(n);
    depth.resize(n);
    slope.resize(n);
    index.resize(n);
  }
  void AddRow() {
    const size_t at = size_t(rows++) * kLanes;
    if (begin.size() < at + kLanes) Grow(std::max<size_t>(at + kLanes, 2 * begin.size()));
    std::fill_n(begin.data() + at, kLanes, kNeverBegins);
    std::fill_n(end.data() + at, kLanes, 0);
    std::fill_n(depth.data() + at, kLanes, 0.0f);
    std::fill_n(slope.data() + at, kLanes, 0.0f);
    std::fill_n(index.data() + at, kLanes, 0);  // Looked up with the others' ids, though never shown.
  }
};

/// Visible pieces of each lane, in ascending order: piece n of lane i is at [n · kLanes + i] and shows entry
/// `entry` of the lane's segment list; empty where begin >= end.
struct VisiblePieces {
  int32_t rows = 0;
  std::vector<int32_t> begin, end, entry;

  /// Makes room for row `row`.
  void Reserve(int32_t row) {
    const size_t wanted = (size_t(row) + 1) * kLanes;
    if (begin.size() >= wanted) return;
    const size_t grown = std::max<size_t>(wanted, 2 * begin.size());
    begin.resize(grown);
    end.resize(grown);
    entry.resize(grown);
  }
};

}  // namespace shutterline::engine
