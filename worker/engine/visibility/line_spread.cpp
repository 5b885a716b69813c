#include "worker/engine/visibility/line_spread.h"

#include <algorithm>
#include <bit>

#include "common/base/check.h"

namespace shutterline::engine {
namespace {

constexpr int kFamilies = 2;
/// Whole numbers in a double.
constexpr int kExactBits = 53;

}  // namespace

LineSpread::LineSpread(const PixelFilter& filter, int lines, int64_t instants)
    : filter_(filter), lines_(lines) {
  SL_CHECK(lines <= kMostLines && std::has_single_bit(unsigned(lines)) && instants > 0);
  // Across, all lines of a family in a pixel together weigh kWhole · kCells.
  const int across_bits = PixelFilter::kWholeLog2 + PixelFilter::kCellsLog2;
  const int instants_bits = std::bit_width(uint64_t(instants - 1));
  // Positions are subpixels, or coarser where so many instants add up that weights would not be exact.
  const int position_bits = std::min(
      kSubpixelBits, kExactBits - instants_bits - PixelFilter::kWholeLog2 - across_bits - (kFamilies - 1));
  SL_CHECK(position_bits >= PixelFilter::kCellsLog2);
  position_shift_ = kSubpixelBits - position_bits;
  cell_shift_ = position_bits - PixelFilter::kCellsLog2;
  cell_length_ = double(int64_t{1} << cell_shift_);
  pixel_total_ = uint64_t(instants) * kFamilies << (position_bits + PixelFilter::kWholeLog2 + across_bits);
  for (int strip = 0; strip < lines; ++strip) {
    for (int k = 0; k < taps(); ++k) {
      across_[size_t(strip)][size_t(k)] = filter.SumOfStrip(lines, strip, k);
    }
  }
}

}  // namespace shutterline::engine
