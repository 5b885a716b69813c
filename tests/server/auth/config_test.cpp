#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/config/config.h"

namespace shutterline::server {
namespace {

using testing::HasSubstr;

absl::Status Check(const std::string& listen, const ListenSecurity& security, bool insecure = false) {
  Config config;
  config.data_dir = "data";
  config.listen = listen;
  config.security = security;
  config.insecure_listen = insecure;
  return Validate(config);
}

const ListenSecurity kNone;
const ListenSecurity kMutual{"cert", "key", "ca", ""};
const ListenSecurity kTlsAndTokens{"cert", "key", "", "tokens"};
const ListenSecurity kTokens{"", "", "", "tokens"};

TEST(ListenSecurity, WithoutTlsTheCoordinatorIsForThisMachineAlone) {
  for (const char* local : {"127.0.0.1:0", "localhost:7400", "[::1]:7400", "127.9.9.9:1"}) {
    EXPECT_TRUE(Check(local, kNone).ok()) << local;
    EXPECT_TRUE(Check(local, kTokens).ok()) << local;
  }
  for (const char* open :
       {"0.0.0.0:7400", "[::]:7400", "192.0.2.1:7400", "host:7400", "127.0.0.1.example.org:7400"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(Check(open, kNone))) << open;
    EXPECT_TRUE(Check(open, kNone, true).ok()) << open;
    EXPECT_TRUE(Check(open, kMutual).ok()) << open;
    EXPECT_TRUE(Check(open, kTlsAndTokens).ok()) << open;
  }
}

TEST(ListenSecurity, TokensNeverTravelUnencryptedWhateverTheNetworkIsTrustedWith) {
  for (const bool insecure : {false, true}) {
    EXPECT_THAT(std::string(Check("0.0.0.0:7400", kTokens, insecure).message()),
                HasSubstr("tokens would travel unencrypted"));
  }
}

TEST(ListenSecurity, HalfOfItIsRefused) {
  EXPECT_THAT(std::string(Check("127.0.0.1:0", {"cert", "", "ca", ""}).message()), HasSubstr("go together"));
  EXPECT_THAT(std::string(Check("127.0.0.1:0", {"", "key", "", ""}).message()), HasSubstr("go together"));
  EXPECT_THAT(std::string(Check("127.0.0.1:0", {"", "", "ca", ""}).message()), HasSubstr("needs tls_cert"));
  EXPECT_THAT(std::string(Check("127.0.0.1:0", {"cert", "key", "", ""}).message()),
              HasSubstr("let everybody in"));
}

}  // namespace
}  // namespace shutterline::server
