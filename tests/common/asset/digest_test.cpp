#include "common/asset/digest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

namespace shutterline {
namespace {

/// The examples of FIPS 180-4 and its appendix.
TEST(Sha256, KnownVectors) {
  EXPECT_EQ(Sha256("").ToHex(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256("abc").ToHex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(Sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq").ToHex(),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(Sha256(std::string(1000000, 'a')).ToHex(),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, PiecesMakeTheSameDigest) {
  const uint32_t seed = 99;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::string data(5000, '\0');
  for (char& c : data) c = char(random());
  for (int trial = 0; trial < 20; ++trial) {
    Sha256Stream stream;
    for (size_t at = 0; at < data.size();) {
      const size_t size = std::min<size_t>(random() % 300, data.size() - at);
      stream.Update(absl::string_view(data).substr(at, size));
      at += size;
    }
    EXPECT_EQ(stream.Finish(), Sha256(data));
  }
}

TEST(Digest, HexRoundTrip) {
  const Digest digest = Sha256("x");
  const auto back = Digest::FromHex(digest.ToHex());
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(*back, digest);
  std::string upper = digest.ToHex();
  for (char& c : upper) c = char(std::toupper(c));
  EXPECT_EQ(Digest::FromHex(upper).value(), digest);
}

TEST(Digest, RefusesWhatIsNoHex) {
  const std::string good = Sha256("x").ToHex();
  for (const std::string& bad :
       {std::string(), good.substr(1), good + "0", good.substr(1) + "g", good.substr(1) + " ",
        good.substr(1) + std::string(1, '\0'), good.substr(1) + "\xff", "0x" + good.substr(2)}) {
    const auto result = Digest::FromHex(bad);
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument) << bad;
  }
  // A huge text is not repeated in full.
  EXPECT_LT(Digest::FromHex(std::string(100000, 'a')).status().message().size(), 300u);
}

TEST(Digest, OrdersLikeItsHex) {
  std::set<Digest> digests;
  std::set<std::string> hex;
  for (int i = 0; i < 50; ++i) {
    digests.insert(Sha256(std::to_string(i)));
    hex.insert(Sha256(std::to_string(i)).ToHex());
  }
  auto text = hex.begin();
  for (const Digest& digest : digests) EXPECT_EQ(digest.ToHex(), *text++);
}

}  // namespace
}  // namespace shutterline
