#include "client/terminal_picture.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "common/image/png.h"

namespace shutterline::client {
namespace {

constexpr size_t kChannels = 4;
/// Half of what lies between the first tiles of the coarse order (server/schedule/tile_order.h).
constexpr int kStandInReach = 4;

}  // namespace

TerminalPicture::TerminalPicture(const TileGrid& grid, int columns, int rows, bool coarse)
    : grid_(grid), coarse_(coarse) {
  SL_CHECK(grid.width > 0 && grid.height > 0 && columns > 0 && rows > 0);
  // A cell is as wide as it is high: half of a character, which is about twice as high as wide.
  const double scale = std::min({double(columns) / grid.width, 2.0 * rows / grid.height, 1.0});
  columns_ = std::max(1, int(std::floor(grid.width * scale)));
  cells_high_ = std::max(2, 2 * int(std::ceil(std::floor(grid.height * scale) / 2)));
  cells_high_ = std::min(cells_high_, 2 * rows);
  side_ = std::clamp(int(std::ceil(kTileSize * scale)), 1, kTileSize);
  tiles_.resize(size_t(grid.Count()));
  means_.resize(size_t(grid.Count()));
}

bool TerminalPicture::SetTile(uint32_t tile, std::span<const float> rgba) {
  if (tile >= tiles_.size() || rgba.size() != size_t(side_) * size_t(side_) * kChannels) return false;
  tiles_[tile].assign(rgba.begin(), rgba.end());
  float sums[3] = {};
  for (size_t i = 0; i < rgba.size(); ++i) {
    if (i % kChannels < 3) sums[i % kChannels] += rgba[i];
  }
  const float count = float(rgba.size() / kChannels);
  means_[tile] = {SrgbByte(sums[0] / count), SrgbByte(sums[1] / count), SrgbByte(sums[2] / count)};
  return true;
}

int TerminalPicture::StandIn(int tile) const {
  const int columns = grid_.Columns();
  const int column = tile % columns, row = tile / columns;
  int nearest = -1, least = 0;
  for (int y = std::max(0, row - kStandInReach); y <= std::min(grid_.Rows() - 1, row + kStandInReach); ++y) {
    for (int x = std::max(0, column - kStandInReach); x <= std::min(columns - 1, column + kStandInReach);
         ++x) {
      if (tiles_[size_t(y * columns + x)].empty()) continue;
      const int distance = (x - column) * (x - column) + (y - row) * (y - row);
      if (nearest >= 0 && distance >= least) continue;
      nearest = y * columns + x;
      least = distance;
    }
  }
  return nearest;
}

TerminalPicture::Colour TerminalPicture::CellColour(int x, int y) const {
  // The pixel at the cell's centre, and the mean of its tile that holds it.
  const int px = std::min(grid_.width - 1, int((x + 0.5) * grid_.width / columns_));
  const int py = std::min(grid_.height - 1, int((y + 0.5) * grid_.height / cells_high_));
  const int index = py / kTileSize * grid_.Columns() + px / kTileSize;
  const std::vector<float>& tile = tiles_[size_t(index)];
  if (tile.empty() && coarse_) {
    if (const int near = StandIn(index); near >= 0) return means_[size_t(near)];
  }
  if (tile.empty())
    return (px / kTileSize + py / kTileSize) % 2 == 0 ? Colour{28, 28, 28} : Colour{38, 38, 38};
  const TileRect rect = grid_.Rect(index);
  const int u = (px - rect.x) * side_ / rect.width, v = (py - rect.y) * side_ / rect.height;
  const float* const mean = &tile[(size_t(v) * size_t(side_) + size_t(u)) * kChannels];
  return {SrgbByte(mean[0]), SrgbByte(mean[1]), SrgbByte(mean[2])};
}

std::vector<std::string> TerminalPicture::Lines() const {
  std::vector<std::string> lines;
  for (int row = 0; row < rows(); ++row) {
    std::string& line = lines.emplace_back();
    Colour upper, lower;
    for (int x = 0; x < columns_; ++x) {
      const Colour above = CellColour(x, 2 * row), below = CellColour(x, 2 * row + 1);
      if (x == 0 || above != upper)
        absl::StrAppend(&line, "\x1b[38;2;", above.r, ";", above.g, ";", above.b, "m");
      if (x == 0 || below != lower)
        absl::StrAppend(&line, "\x1b[48;2;", below.r, ";", below.g, ";", below.b, "m");
      upper = above;
      lower = below;
      line += "▀";  // Its upper half in the foreground's colour.
    }
    line += "\x1b[0m";
  }
  return lines;
}

}  // namespace shutterline::client
