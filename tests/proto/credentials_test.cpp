#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>

#include "proto/credentials/channel_credentials.h"
#include "proto/credentials/key_pair.h"
#include "proto/credentials/private_file.h"
#include "proto/credentials/token.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::credentials {
namespace {

using testing::HasSubstr;

class CredentialsTest : public testing::Test {
 protected:
  std::string File(const std::string& name, const std::string& content, mode_t mode = 0600) {
    std::string path = absl::StrCat(folder_.path(), "/", name);
    std::ofstream(path, std::ios::binary) << content;
    EXPECT_EQ(chmod(path.c_str(), mode), 0);
    return path;
  }
  /// Runs deploy/certs on the folder.
  void Certs(const std::string& arguments) {
    const std::string command = absl::StrCat(SHUTTERLINE_SOURCE_DIR "/deploy/certs ", folder_.path(), " ",
                                             arguments, " >/dev/null 2>&1");
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
  std::string Path(const std::string& name) const { return absl::StrCat(folder_.path(), "/", name); }

  const test::TemporaryFolder folder_;
  const std::string token_ = std::string(64, 'a');
};

TEST_F(CredentialsTest, SecretsAreNotReadFromFilesThatOthersRead) {
  for (const mode_t mode : {0644, 0604, 0660, 0666}) {
    const auto read = ReadPrivateFile(File("f", "x", mode), "the key", Secrecy::kSecret);
    EXPECT_TRUE(absl::IsPermissionDenied(read.status())) << std::oct << mode;
    EXPECT_THAT(std::string(read.status().message()), HasSubstr("chmod 0600"));
  }
  EXPECT_EQ(*ReadPrivateFile(File("f", "x", 0640), "the key", Secrecy::kSecret), "x");
  EXPECT_EQ(*ReadPrivateFile(File("f", "x", 0644), "the certificate", Secrecy::kPublic), "x");
  EXPECT_TRUE(absl::IsPermissionDenied(
      ReadPrivateFile(File("f", "x", 0664), "the certificate", Secrecy::kPublic).status()));
}

TEST_F(CredentialsTest, WhatIsNoPlainFileOfSomeBytesIsRefused) {
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  for (const std::string& path :
       {folder_.path(), Path("pipe"), File("empty", ""), File("large", std::string((1 << 20) + 1, 'x'))}) {
    EXPECT_TRUE(absl::IsInvalidArgument(ReadPrivateFile(path, "the key", Secrecy::kSecret).status())) << path;
  }
  EXPECT_TRUE(absl::IsNotFound(ReadPrivateFile(Path("none"), "the key", Secrecy::kSecret).status()));
}

TEST_F(CredentialsTest, TokensAreOfOneKind) {
  EXPECT_EQ(*LoadToken(File("t", absl::StrCat(token_, "\n"))), token_);
  EXPECT_FALSE(LoadToken(File("t", "short\n")).ok());
  EXPECT_FALSE(LoadToken(File("t", std::string(513, 'a'))).ok());
  const auto two_lines = LoadToken(File("t", absl::StrCat(token_, "\n", token_, "\n")));
  EXPECT_THAT(std::string(two_lines.status().message()), HasSubstr("other characters"));
  EXPECT_THAT(std::string(two_lines.status().message()), testing::Not(HasSubstr(token_)));
}

TEST_F(CredentialsTest, ATokenGoesUnencryptedToThisMachineAlone) {
  DialSecurity security;
  security.token_file = File("t", token_);
  for (const char* local : {"localhost:7400", "127.0.0.1:7400", "[::1]:7400"}) {
    EXPECT_TRUE(MakeChannelCredentials(security, local).ok()) << local;
  }
  for (const char* remote :
       {"farm:7400", "192.0.2.1:7400", "[2001:db8::1]:7400", "localhost.example.org:7400"}) {
    EXPECT_TRUE(absl::IsFailedPrecondition(MakeChannelCredentials(security, remote).status())) << remote;
  }
}

TEST_F(CredentialsTest, KeysAndCertificatesMustBelongTogether) {
  Certs("ca");
  Certs("worker one");
  Certs("worker two");
  EXPECT_TRUE(LoadKeyPair(Path("worker-one.pem"), Path("worker-one.key")).ok());
  EXPECT_TRUE(LoadAuthorities(Path("ca.pem")).ok());
  EXPECT_THAT(std::string(LoadKeyPair(Path("worker-one.pem"), Path("worker-two.key")).status().message()),
              HasSubstr("worker-two.key: is not the key of the certificate"));
  EXPECT_THAT(std::string(LoadKeyPair(Path("worker-one.key"), Path("worker-one.key")).status().message()),
              HasSubstr("holds no certificate"));
  EXPECT_THAT(
      std::string(LoadAuthorities(File("junk", "-----BEGIN CERTIFICATE-----\nAAAA\n")).status().message()),
      HasSubstr("holds no certificate"));
  ASSERT_EQ(chmod(Path("worker-one.key").c_str(), 0644), 0);
  EXPECT_TRUE(absl::IsPermissionDenied(LoadKeyPair(Path("worker-one.pem"), Path("worker-one.key")).status()));
}

TEST_F(CredentialsTest, OptionsThatMissTheirOtherHalfAreRefused) {
  EXPECT_THAT(std::string(MakeChannelCredentials({"", "c", "", ""}, "h:1").status().message()),
              HasSubstr("go together"));
  EXPECT_THAT(std::string(MakeChannelCredentials({"", "c", "k", ""}, "h:1").status().message()),
              HasSubstr("needs --tls-ca"));
  EXPECT_TRUE(MakeChannelCredentials({}, "h:1").ok());
}

}  // namespace
}  // namespace shutterline::credentials
