#include "worker/engine/shading/texel_group.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>

namespace shutterline::engine {
namespace {

constexpr int kBits = 5;

Texel RandomTexel(std::mt19937_64& random, int level1, int level2) {
  return {level1, level2, uint32_t(random() % (uint64_t{1} << level1)),
          uint32_t(random() % (uint64_t{1} << level2))};
}

TEST(TexelGroup, TellsAllTexelsApart) {
  std::mt19937_64 random(3);
  std::map<std::tuple<uint64_t, uint32_t, uint32_t>, std::pair<uint32_t, TexelKey>> seen;
  for (int i = 0; i < 100'000; ++i) {
    // Small numbers, so that neighbours are drawn, and all levels that a key has room for.
    const bool small = random() % 4 != 0;
    const int level1 = int(random() % (small ? 4 : 32));
    const int level2 =
        int(random() % (small ? 4u : unsigned(std::min(31, Texel::kMaxLevelSum - level1)) + 1));
    const auto triangle = uint32_t(small ? random() % 100 : random());
    const TexelKey key = RandomTexel(random, level1, level2).KeyOf(triangle);
    const TexelGroup group = TexelGroup::Of(key, kBits);
    ASSERT_LT(group.member, 1u << kBits);
    const auto [place, added] = seen.insert({{group.place, group.triangle, group.member}, {triangle, key}});
    ASSERT_TRUE(added || place->second.second == key) << triangle << " and " << place->second.first;
  }
}

TEST(TexelGroup, HoldsAWholeBlockOfATriangleOrOfATrainOfThem) {
  for (int level1 = 0; level1 <= 6; ++level1) {
    for (int level2 = 0; level2 <= 6; ++level2) {
      std::map<std::pair<uint64_t, uint32_t>, int> members;
      int texels = 0;
      for (uint32_t triangle = 64; triangle < 128; ++triangle) {
        for (uint32_t i = 0; i >> level1 == 0; ++i) {
          for (uint32_t j = 0; j >> level2 == 0; ++j, ++texels) {
            const TexelGroup group = TexelGroup::Of(Texel{level1, level2, i, j}.KeyOf(triangle), kBits);
            ++members[{group.place, group.triangle}];
          }
        }
      }
      EXPECT_EQ(int(members.size()), texels >> kBits) << level1 << ", " << level2;
      for (const auto& [group, count] : members) EXPECT_EQ(count, 1 << kBits);
    }
  }
}

}  // namespace
}  // namespace shutterline::engine
