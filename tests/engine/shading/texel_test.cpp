#include "worker/engine/shading/texel.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <set>

#include "worker/engine/shading/footprint.h"
#include "worker/engine/shading/texel_levels.h"

namespace shutterline::engine {
namespace {

/// A flat triangle whose barycentric coordinates change by `db1` a pixel to the right and `db2` a pixel down.
std::array<RasterPoint, 3> TriangleOf(double db1, double db2) {
  return {RasterPoint{0, 0, 1, 1}, RasterPoint{1 / db1, 0, 1, 1}, RasterPoint{0, 1 / db2, 1, 1}};
}

std::optional<Texel> TexelAt(const Barycentric& at, const std::array<RasterPoint, 3>& triangle, double rate) {
  const std::optional<TexelLevels> levels = TexelLevelsOfTriangle(triangle, rate).At(at);
  return levels ? std::optional(TexelAt(at, *levels)) : std::nullopt;
}

TEST(Texel, OfATriangleWithinAPixelIsAllOfIt) {
  const auto texel = TexelAt({0.7, 0.2}, TriangleOf(3, 1.1), 1);
  ASSERT_TRUE(texel.has_value());
  EXPECT_TRUE(texel->IsTop());
  EXPECT_NEAR(texel->Centre().b1, 1.0 / 3, 1e-15);
  EXPECT_NEAR(texel->Centre().b2, 1.0 / 3, 1e-15);
}

TEST(Texel, IsAboutAPixelOverTheRateInBothDirections) {
  std::mt19937 random(7);
  for (int i = 0; i < 10'000; ++i) {
    const auto uniform = [&] { return std::uniform_real_distribution<double>()(random); };
    const double db1 = std::exp2(-10 * uniform()), db2 = std::exp2(-10 * uniform());
    const double rate = std::exp2(4 * uniform() - 2);
    const double b1 = uniform(), b2 = uniform() * (1 - b1);
    const auto texel = TexelAt({b1, b2}, TriangleOf(db1, db2), rate);
    ASSERT_TRUE(texel.has_value());
    const double sides[2] = {std::exp2(-texel->level1) * rate / db1, std::exp2(-texel->level2) * rate / db2};
    for (const double side : sides) EXPECT_LE(side, 1.4143);
    EXPECT_TRUE(texel->level1 == 0 || sides[0] >= 0.7071) << sides[0];
    EXPECT_TRUE(texel->level2 == 0 || sides[1] >= 0.7071) << sides[1];
    // The point is in it, the centre as well, and that lies in the triangle.
    const double width = std::exp2(-texel->level1), height = std::exp2(-texel->level2);
    const Barycentric centre = texel->Centre();
    for (const Barycentric& p : {Barycentric{b1, b2}, centre}) {
      EXPECT_GE(p.b1, texel->i * width - 1e-12);
      EXPECT_LE(p.b1, (texel->i + 1) * width + 1e-12);
      EXPECT_GE(p.b2, texel->j * height - 1e-12);
      EXPECT_LE(p.b2, (texel->j + 1) * height + 1e-12);
    }
    EXPECT_LE(centre.b1 + centre.b2, 1);
  }
}

TEST(Texel, CentreIsTheCentroidOfWhatLiesInTheTriangle) {
  for (const Texel texel : {Texel{1, 0, 0, 0}, Texel{1, 0, 1, 0}, Texel{2, 1, 1, 0}, Texel{2, 2, 1, 2},
                            Texel{0, 3, 0, 5}, Texel{3, 1, 2, 1}}) {
    // By brute force.
    const double width = std::exp2(-texel.level1), height = std::exp2(-texel.level2);
    constexpr int kSteps = 2000;
    double area = 0, x = 0, y = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double b1 = (texel.i + (i + 0.5) / kSteps) * width;
      const double top = std::min((texel.j + 1) * height, 1 - b1), bottom = texel.j * height;
      if (top <= bottom) continue;
      area += top - bottom;
      x += (top - bottom) * b1;
      y += (top - bottom) * (top + bottom) / 2;
    }
    EXPECT_NEAR(texel.Centre().b1, x / area, 1e-6) << texel.level1 << texel.level2;
    EXPECT_NEAR(texel.Centre().b2, y / area, 1e-6) << texel.level1 << texel.level2;
  }
}

TEST(Texel, PointsOnTheLongSideAreInTexelsOfTheTriangle) {
  for (int level = 0; level <= 12; ++level) {
    const double pixel = std::exp2(-level);
    for (int k = 0; k <= 1 << level; k += 1 + (1 << level) / 64) {
      const double b1 = k * pixel;
      const auto texel = TexelAt({b1, 1 - b1}, TriangleOf(pixel, pixel), 1);
      ASSERT_TRUE(texel.has_value());
      EXPECT_LT(texel->i + texel->j, 1u << level) << level << " " << k;
      const Barycentric centre = texel->Centre();
      EXPECT_TRUE(centre.b1 >= 0 && centre.b2 >= 0 && centre.b1 + centre.b2 <= 1);
    }
  }
}

TEST(Texel, LevelsAreTheLeastWhoseTexelsAreShorterThanTheRootOfTwo) {
  std::mt19937_64 random(11);
  for (int i = 0; i < 100'000; ++i) {
    const double per_pixel = std::exp2(-30 * std::uniform_real_distribution<double>()(random));
    const auto levels = TexelLevelsOfTriangle(TriangleOf(per_pixel, 1), 1).At({0.2, 0.2});
    ASSERT_TRUE(levels.has_value());
    const double side = std::exp2(-levels->level1) / per_pixel;
    ASSERT_LE(side, std::sqrt(2) * (1 + 1e-12)) << per_pixel;
    ASSERT_TRUE(levels->level1 == 0 || 2 * side > std::sqrt(2) * (1 - 1e-12)) << per_pixel;
  }
  for (int level = 0; level <= 30; ++level) {
    EXPECT_EQ(TexelLevelsOfTriangle(TriangleOf(std::exp2(-level), 1), 1).At({0, 0})->level1, level);
  }
}

TEST(Texel, LevelsFollowThePixelsFootprintInPerspective) {
  std::mt19937 random(13);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int uneven = 0;
  for (int i = 0; i < 5'000; ++i) {
    std::array<RasterPoint, 3> corners;
    for (RasterPoint& corner : corners) {
      const double w = std::exp2(uniform(-3, 3));
      corner = {w * uniform(-500, 500), w * uniform(-500, 500), 1, w};
    }
    const double rate = std::exp2(uniform(-2, 2));
    const TexelLevelsOfTriangle levels(corners, rate);
    std::set<int> met;
    for (int k = 0; k < 10; ++k) {
      const double b1 = uniform(0, 1), b2 = uniform(0, 1 - b1);
      const auto found = levels.At({b1, b2});
      ASSERT_TRUE(found.has_value());
      met.insert(found->level1);
      const Footprint f = PixelFootprint(corners, {b1, b2});
      const double side = std::exp2(-found->level1) * rate / std::hypot(f.db1_dx, f.db1_dy);
      // Where corners and middle agree, what lies between is taken to.
      EXPECT_LE(side, 1.4143 * 1.5) << "triangle " << i;
      EXPECT_TRUE(found->level1 == 0 || side > 0.7071 / 1.5) << "triangle " << i << ": " << side;
    }
    if (met.size() > 1) ++uneven;
  }
  EXPECT_GT(uneven, 500);
}

TEST(Texel, WhereThereIsNoFootprintOrNoRoomThereIsNone) {
  EXPECT_FALSE(TexelAt({0.1, 0.1}, {}, 1).has_value());
  const RasterPoint p{3, 4, 1, 1};
  EXPECT_FALSE(TexelAt({0.1, 0.1}, std::array{p, p, p}, 1).has_value());
  auto behind = TriangleOf(0.1, 0.1);
  for (RasterPoint& corner : behind) corner.w = -1;
  EXPECT_FALSE(TexelAt({0.1, 0.1}, behind, 1).has_value());
  EXPECT_FALSE(TexelAt({0.1, 0.1}, TriangleOf(std::exp2(-32), 1), 1).has_value());
  EXPECT_TRUE(TexelAt({0.1, 0.1}, TriangleOf(std::exp2(-31), 1), 1).has_value());
  EXPECT_FALSE(TexelAt({0.1, 0.1}, TriangleOf(std::exp2(-27), std::exp2(-27)), 1).has_value());
  EXPECT_TRUE(TexelAt({0.1, 0.1}, TriangleOf(std::exp2(-27), std::exp2(-26)), 1).has_value());
}

TEST(Texel, KeysDifferAndParentsHoldTheirChildren) {
  std::set<TexelKey> keys;
  size_t count = 0;
  for (const uint32_t triangle : {0u, 1u, 0xffffffffu}) {
    for (int level1 = 0; level1 <= 4; ++level1) {
      for (int level2 = 0; level2 <= 4; ++level2) {
        for (uint32_t i = 0; i < 1u << level1; ++i) {
          for (uint32_t j = 0; j < 1u << level2; ++j) {
            const Texel texel{level1, level2, i, j};
            keys.insert(texel.KeyOf(triangle));
            ++count;
            if (texel.IsTop()) continue;
            const Texel parent = texel.Parent();
            EXPECT_EQ(i * std::exp2(parent.level1 - level1) >= parent.i, true);
            EXPECT_EQ(i * std::exp2(parent.level1 - level1) < parent.i + 1, true);
            EXPECT_EQ(j * std::exp2(parent.level2 - level2) < parent.j + 1, true);
          }
        }
      }
    }
  }
  EXPECT_EQ(keys.size(), count);
  // Far down every bit of the place counts.
  const Texel deep{27, 26, 0x5555555, 0x2aaaaaa};
  std::set<TexelKey> others{deep.KeyOf(7)};
  for (int bit = 0; bit < 27; ++bit) others.insert(Texel{27, 26, deep.i ^ 1u << bit, deep.j}.KeyOf(7));
  for (int bit = 0; bit < 26; ++bit) others.insert(Texel{27, 26, deep.i, deep.j ^ 1u << bit}.KeyOf(7));
  EXPECT_EQ(others.size(), 54u);
  EXPECT_LT(deep.KeyOf(7).high, 1u << 31);
}

}  // namespace
}  // namespace shutterline::engine
