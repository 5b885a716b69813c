#include "common/cryptomatte/cryptomatte.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "common/cryptomatte/murmur_hash.h"

namespace shutterline {
namespace {

TEST(MurmurHash3, PublishedValues) {
  // Of the verification texts that circulate with the algorithm, seed 0.
  EXPECT_EQ(MurmurHash3(""), 0u);
  EXPECT_EQ(MurmurHash3("a"), 0x3c2569b2u);
  EXPECT_EQ(MurmurHash3("test"), 0xba6bd213u);
  EXPECT_EQ(MurmurHash3("Hello, world!"), 0xc0363e43u);
  EXPECT_EQ(MurmurHash3("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
}

TEST(Cryptomatte, IdsAreFloatsThatSurviveEveryFile) {
  EXPECT_EQ(MatteIdBits("hello"), 0x248bfa47u);
  std::mt19937 random(3);
  int turned = 0;
  for (int i = 0; i < 200'000; ++i) {
    const std::string name = "object_" + std::to_string(random());
    const float id = MatteId(name);
    ASSERT_TRUE(std::isnormal(id)) << name;
    if (MatteIdBits(name) != MurmurHash3(name)) ++turned;
  }
  // Two exponents of 256 are turned.
  EXPECT_NEAR(turned / 200'000.0, 2 / 256.0, 0.001);
}

TEST(Cryptomatte, MetadataHasAPrefixOfItsOwnAndTheNamesOfAll) {
  std::map<std::string, std::string> attributes;
  AddMatteMetadata("CryptoObject", {"wheel", "", "Rad \"links\"", "bad \xff byte"}, attributes);
  ASSERT_EQ(attributes.size(), 4u);
  // "cryptomatte/", seven digits of the layer's hash, "/".
  const std::string key = attributes.begin()->first.substr(0, 20);
  EXPECT_EQ(key.find("cryptomatte/"), 0u);
  EXPECT_EQ(key.find_first_not_of("0123456789abcdef", 12), 19u);
  EXPECT_EQ(attributes.at(key + "name"), "CryptoObject");
  EXPECT_EQ(attributes.at(key + "hash"), "MurmurHash3_32");
  EXPECT_EQ(attributes.at(key + "conversion"), "uint32_to_float32");
  const nlohmann::json manifest = nlohmann::json::parse(attributes.at(key + "manifest"));
  EXPECT_EQ(manifest.size(), 3u);
  EXPECT_EQ(manifest.at("wheel").get<std::string>().size(), 8u);
  EXPECT_TRUE(manifest.contains("Rad \"links\""));
}

}  // namespace
}  // namespace shutterline
