#include "client/terminal_picture.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include "common/image/png.h"

namespace shutterline::client::terminal_picture_test {
namespace {

/// Characters that the row shows, without its colours.
int CharactersOf(const std::string& row) {
  int count = 0;
  bool escape = false;
  for (const char c : row) {
    if (c == '\x1b') escape = true;
    // Of a character of several bytes the first counts.
    if (!escape && (static_cast<unsigned char>(c) & 0xC0) != 0x80) ++count;
    if (escape && c == 'm') escape = false;
  }
  return count;
}

TEST(TerminalPicture, FitsAndKeepsTheFramesShape) {
  for (const TileGrid grid : {TileGrid{1024, 768}, TileGrid{8192, 100}, TileGrid{100, 8192}, TileGrid{1, 1},
                              TileGrid{33, 31}, TileGrid{16384, 16384}}) {
    for (const auto& [columns, rows] :
         {std::pair{80, 24}, std::pair{1, 1}, std::pair{200, 3}, std::pair{7, 50}}) {
      SCOPED_TRACE(absl::StrCat(grid.width, "x", grid.height, " in ", columns, "x", rows));
      const TerminalPicture picture(grid, columns, rows);
      EXPECT_LE(picture.columns(), columns);
      EXPECT_LE(picture.rows(), rows);
      EXPECT_GE(picture.tile_side(), 1);
      EXPECT_LE(picture.tile_side(), kTileSize);
      const auto lines = picture.Lines();
      ASSERT_EQ(lines.size(), size_t(picture.rows()));
      for (const std::string& line : lines) EXPECT_EQ(CharactersOf(line), picture.columns());
    }
  }
  const TerminalPicture wide(TileGrid{1024, 768}, 80, 60);
  EXPECT_EQ(wide.columns(), 80);
  EXPECT_EQ(wide.rows(), 30);  // 60 cells: 3/4 of 80.
}

TEST(TerminalPicture, ATileChangesItsOwnPlaceAlone) {
  // 4 × 2 tiles in 8 × 2 characters: each tile is two characters wide and one high.
  TerminalPicture picture(TileGrid{128, 64}, 8, 2);
  const auto before = picture.Lines();
  const size_t side = size_t(picture.tile_side());
  std::vector<float> tile;
  for (size_t i = 0; i < side * side; ++i) tile.insert(tile.end(), {1.0f, 0.5f, 0.0f, 1.0f});
  ASSERT_TRUE(picture.SetTile(5, tile));  // Second row, second column.
  const auto after = picture.Lines();
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0], before[0]);
  EXPECT_NE(after[1], before[1]);
  const std::string colour = absl::StrCat("255;", int(SrgbByte(0.5f)), ";0m");
  EXPECT_NE(after[1].find("\x1b[38;2;" + colour), std::string::npos) << after[1];
  EXPECT_NE(after[1].find("\x1b[48;2;" + colour), std::string::npos);
  // Colours are said where they change: once here, though two characters have them.
  EXPECT_EQ(after[1].find("38;2;" + colour), after[1].rfind("38;2;" + colour));
}

/// The colour of the upper cell of each character, as "r;g;b".
std::vector<std::string> UpperColours(const std::string& line) {
  const std::string upper = "\x1b[38;2;", cell = "▀";
  std::vector<std::string> colours;
  std::string colour;
  for (size_t i = 0; i < line.size(); ++i) {
    if (line.compare(i, upper.size(), upper) == 0) {
      const size_t from = i + upper.size();
      colour = line.substr(from, line.find('m', from) - from);
    }
    if (line.compare(i, cell.size(), cell) == 0) colours.push_back(colour);
  }
  return colours;
}

TEST(TerminalPicture, ACoarseOneIsFilledByTheNearestTiles) {
  // 12 × 1 tiles, two characters each.
  const TileGrid grid{12 * kTileSize, kTileSize};
  TerminalPicture plain(grid, 24, 1), coarse(grid, 24, 1, true);
  EXPECT_EQ(coarse.Lines(), plain.Lines());  // Nothing is there.
  ASSERT_EQ(coarse.tile_side(), 2);
  const auto paint = [](TerminalPicture& picture, uint32_t tile, float red) {
    std::vector<float> rgba;
    for (const float share : {1.5f, 0.5f, 1.5f, 0.5f}) rgba.insert(rgba.end(), {share * red, 0, 0, 1});
    ASSERT_TRUE(picture.SetTile(tile, rgba));
  };
  std::vector<std::string> expected = UpperColours(plain.Lines()[0]);
  for (TerminalPicture* picture : {&plain, &coarse}) {
    paint(*picture, 1, 0.5f);
    paint(*picture, 6, 0.25f);
  }
  const auto at = [&](size_t tile, float left, float right) {
    expected[2 * tile] = absl::StrCat(int(SrgbByte(left)), ";0;0");
    expected[2 * tile + 1] = absl::StrCat(int(SrgbByte(right)), ";0;0");
  };
  at(1, 0.75f, 0.25f);
  at(6, 0.375f, 0.125f);
  EXPECT_EQ(UpperColours(plain.Lines()[0]), expected);
  for (const size_t tile : {0, 2, 3}) at(tile, 0.5f, 0.5f);
  for (const size_t tile : {4, 5, 7, 8, 9, 10}) at(tile, 0.25f, 0.25f);
  EXPECT_EQ(UpperColours(coarse.Lines()[0]), expected);  // The last is too far from both.
}

TEST(TerminalPicture, WhatDoesNotFitIsLeftOut) {
  TerminalPicture picture(TileGrid{128, 64}, 8, 2);
  const auto before = picture.Lines();
  const size_t side = size_t(picture.tile_side());
  const std::vector<float> right(side * side * 4, 1.0f), wrong(side * side * 4 + 1, 1.0f);
  EXPECT_FALSE(picture.SetTile(8, right));
  EXPECT_FALSE(picture.SetTile(0, wrong));
  EXPECT_FALSE(picture.SetTile(0, {}));
  EXPECT_EQ(picture.Lines(), before);
  EXPECT_TRUE(picture.SetTile(7, right));
}

TEST(TerminalPicture, AFrameOfOnePixelAndColoursThatAreNone) {
  TerminalPicture picture(TileGrid{1, 1}, 80, 24);
  std::vector<float> tile(size_t(picture.tile_side() * picture.tile_side() * 4),
                          std::numeric_limits<float>::quiet_NaN());
  ASSERT_TRUE(picture.SetTile(0, tile));
  EXPECT_NE(picture.Lines()[0].find("38;2;0;0;0m"), std::string::npos);
}

}  // namespace
}  // namespace shutterline::client::terminal_picture_test
