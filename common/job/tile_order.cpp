#include "common/job/tile_order.h"

#include <array>

namespace shutterline {
namespace {

constexpr std::array<absl::string_view, 3> kWords = {"hilbert", "center", "coarse"};

}  // namespace

absl::string_view ToString(TileOrder order) {
  return kWords[size_t(order)];
}

std::optional<TileOrder> ParseTileOrder(absl::string_view word) {
  for (size_t i = 0; i < kWords.size(); ++i) {
    if (kWords[i] == word) return TileOrder(i);
  }
  return std::nullopt;
}

}  // namespace shutterline
