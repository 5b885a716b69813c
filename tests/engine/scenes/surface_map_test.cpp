#include "tests/scenes/surface_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/scenes/cloth.h"
#include "tests/scenes/marble.h"
#include "tests/scenes/noise.h"
#include "tests/scenes/skin.h"
#include "tests/scenes/stone.h"
#include "tests/scenes/wood.h"

namespace shutterline::scenes {
namespace {

constexpr int kSize = 256;

TEST(Noise, RepeatsAfterTheUnitSquare) {
  for (int i = 0; i < 200; ++i) {
    const double u = HashOf(i, 0, 1), v = HashOf(i, 1, 1);
    EXPECT_NEAR(FractalNoise(u, v, 3, 5, 4, 7), FractalNoise(u + 1, v - 2, 3, 5, 4, 7), 1e-9);
    const Cell cell = CellAt(u, v, 4, 6, 9), again = CellAt(u - 1, v + 1, 4, 6, 9);
    EXPECT_NEAR(cell.nearest, again.nearest, 1e-9);
    EXPECT_NEAR(cell.second, again.second, 1e-9);
    EXPECT_EQ(cell.number, again.number);
    EXPECT_LE(cell.nearest, cell.second);
  }
}

TEST(Noise, IsBalancedAndBounded) {
  double sum = 0, least = 1, most = -1;
  constexpr int kSide = 200;
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const double value = GradientNoise(i * 0.16 + 0.01, j * 0.16 + 0.07, 32, 32, 3);
      sum += value;
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  EXPECT_NEAR(sum / kSide / kSide, 0, 0.03);
  EXPECT_LT(least, -0.5);
  EXPECT_GT(most, 0.5);
  EXPECT_GT(least, -1.6);
  EXPECT_LT(most, 1.6);
}

/// A slope down to the right and a slope down to the bottom of the picture face there: right, and down,
/// which in a normal map is a small green.
TEST(SurfaceMap, NormalsFaceDownhill) {
  const auto slope = [](double right, double down) {
    return NormalPicture(
        SurfaceMap(8, [&](double u, double v) { return SurfacePoint{.height = -right * u - down * v}; }));
  };
  const size_t middle = 3 * (4 * 8 + 4);
  const PngPicture right = slope(1, 0), down = slope(0, 1), flat = slope(0, 0);
  EXPECT_EQ(right.samples[middle], std::floor(255 * (0.5 + 0.5 * std::sqrt(0.5)) + 0.5));
  EXPECT_EQ(right.samples[middle + 1], 128);
  EXPECT_EQ(down.samples[middle], 128);
  EXPECT_EQ(down.samples[middle + 1], std::floor(255 * (0.5 - 0.5 * std::sqrt(0.5)) + 0.5));
  EXPECT_EQ(flat.samples[middle + 2], 255);
}

struct Family {
  const char* name;
  SurfaceMap (*make)();
  friend void PrintTo(const Family& family, std::ostream* out) { *out << family.name; }
};

const Family kFamilies[] = {
    {"Maple", [] { return Wood(kSize, Maple(), 1); }},
    {"Walnut", [] { return Wood(kSize, Walnut(), 2); }},
    {"Mahogany", [] { return Wood(kSize, Mahogany(), 3); }},
    {"Rosewood", [] { return Wood(kSize, Rosewood(), 4); }},
    {"WhiteMarble", [] { return Marble(kSize, WhiteMarble(), 5); }},
    {"CreamMarble", [] { return Marble(kSize, CreamMarble(), 6); }},
    {"Checkers", [] { return MarbleChecker(kSize, WhiteMarble(), GreenMarble(), 4, 7); }},
    {"FloorTiles", [] { return FloorTiles(kSize, Travertine(), 4, 8); }},
    {"Masonry", [] { return Masonry(kSize, Sandstone(), 6, 9); }},
    {"Rock", [] { return Rock(kSize, Terracotta(), 10); }},
    {"Plaster", [] { return Plaster(kSize, SrgbCode(0xf0dcb4), 11); }},
    {"Tartan", [] { return Tartan(kSize, 32, 12); }},
    {"Banner", [] { return Banner(kSize, 48, SrgbCode(0x23599c), SrgbCode(0xe3c98a), 13); }},
    {"Hide", [] { return Hide(kSize, 12, 14); }},
};

class Surface : public testing::TestWithParam<Family> {};

/// What differs on average between neighbours left and right of column `x`'s right border, or above and
/// below row `x`'s lower border.
double Step(const PngPicture& picture, int x, bool rows) {
  double sum = 0;
  const auto at = [&](int along, int across) {
    const int column = rows ? across : along, row = rows ? along : across;
    return 3 * (size_t(row) * size_t(picture.width) + size_t(column));
  };
  for (int y = 0; y < picture.height; ++y) {
    for (size_t c = 0; c < 3; ++c) {
      sum += std::abs(double(picture.samples[at(x, y) + c]) -
                      double(picture.samples[at((x + 1) % picture.width, y) + c]));
    }
  }
  return sum / (3 * picture.height);
}

TEST_P(Surface, BordersDifferNoMoreThanNeighbours) {
  const SurfaceMap map = GetParam().make();
  for (const PngPicture& picture : {ColorPicture(map), RoughnessPicture(map), NormalPicture(map)}) {
    for (const bool rows : {false, true}) {
      double most = 0;
      for (int x = 0; x < kSize - 1; ++x) most = std::max(most, Step(picture, x, rows));
      // Joints lie on borders and elsewhere, and differ by chance.
      EXPECT_LE(Step(picture, kSize - 1, rows), 1.1 * most) << (rows ? "rows" : "columns");
    }
  }
}

TEST_P(Surface, IsNotFlat) {
  const SurfaceMap map = GetParam().make();
  const auto deviation = [](const PngPicture& picture, size_t channel) {
    double sum = 0, squares = 0;
    const size_t count = picture.samples.size() / 3;
    for (size_t i = 0; i < count; ++i) {
      const double sample = picture.samples[3 * i + channel];
      sum += sample;
      squares += sample * sample;
    }
    const double mean = sum / double(count);
    return std::sqrt(squares / double(count) - mean * mean);
  };
  EXPECT_GT(deviation(ColorPicture(map), 1), 4);  // Of 255.
  EXPECT_GT(deviation(RoughnessPicture(map), 1), 1);
  EXPECT_EQ(deviation(RoughnessPicture(map), 2), 0);
}

TEST_P(Surface, IsTheSameAgain) {
  const SurfaceMap first = GetParam().make(), second = GetParam().make();
  EXPECT_TRUE(ColorPicture(first).samples == ColorPicture(second).samples);
  EXPECT_TRUE(RoughnessPicture(first).samples == RoughnessPicture(second).samples);
  EXPECT_TRUE(NormalPicture(first).samples == NormalPicture(second).samples);
}

INSTANTIATE_TEST_SUITE_P(All, Surface, testing::ValuesIn(kFamilies),
                         [](const auto& family) { return std::string(family.param.name); });

}  // namespace
}  // namespace shutterline::scenes
