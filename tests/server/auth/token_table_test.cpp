#include "server/auth/token_table.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace shutterline::server {
namespace {

using testing::HasSubstr;

std::string Line(const std::string& role, const std::string& name, const std::string& token) {
  return absl::StrCat(role, " ", name, " ", Sha256(token).ToHex(), "\n");
}

TEST(TokenTable, FindsTheCallerOfATokenAndOfNoOther) {
  const auto table = TokenTable::Parse(absl::StrCat("# people\n\n", Line("client", "alice", "secret-a"), "  ",
                                                    Line("client", "alice", "secret-b"),
                                                    Line("admin", "root@farm", "secret-c"), "# end"));
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->size(), 3u);
  for (const char* token : {"secret-a", "secret-b"}) {  // Both of hers, while one replaces the other.
    const auto caller = table->Find(token);
    ASSERT_TRUE(caller.has_value());
    EXPECT_EQ(caller->name, "alice");
    EXPECT_EQ(caller->roles.ToString(), "client");
  }
  EXPECT_EQ(table->Find("secret-c")->roles.ToString(), "admin");
  for (const char* token : {"", "secret", "secret-d", "secret-a ", "alice"}) {
    EXPECT_FALSE(table->Find(token).has_value()) << token;
  }
  EXPECT_FALSE(table->Find(Sha256("secret-a").ToHex()).has_value()) << "the file's own words are no tokens";
}

TEST(TokenTable, RefusesWhatIsNoTableAndNamesTheLine) {
  const std::string good = Line("client", "alice", "a");
  const struct {
    std::string text, reason;
  } cases[] = {
      {"", "names no token"},
      {"# nothing\n", "names no token"},
      {absl::StrCat(good, "client bob\n"), "line 2: is not 'role name sha256'"},
      {absl::StrCat(good, "client bob cafe 1\n"), "line 2: is not 'role name sha256'"},
      {Line("root", "alice", "a"), "line 1: the role must be"},
      {Line("client", std::string(65, 'x'), "a"), "line 1: the name must be"},
      {Line("client", "a\x01", "a"), "line 1: the name must be"},
      {"client alice cafe\n", "line 1: the last word must be the token's SHA-256"},
      {absl::StrCat(good, Line("client", "bob", "a")), "line 2: has the token of another line"},
      {absl::StrCat(good, Line("admin", "alice", "b")), "line 2: 'alice' has another role"},
  };
  for (const auto& c : cases) {
    const auto table = TokenTable::Parse(c.text);
    EXPECT_TRUE(absl::IsInvalidArgument(table.status())) << c.text;
    EXPECT_THAT(std::string(table.status().message()), HasSubstr(c.reason)) << c.text;
  }
}

TEST(TokenTable, IsNotReadFromAFileThatOthersMayReadOrWrite) {
  const test::TemporaryFolder folder;
  const std::string file = absl::StrCat(folder.path(), "/tokens");
  std::ofstream(file) << Line("client", "alice", "a");
  for (const mode_t mode : {0644, 0666, 0620, 0602}) {
    ASSERT_EQ(chmod(file.c_str(), mode), 0);
    const auto table = TokenTable::Load(file);
    EXPECT_TRUE(absl::IsPermissionDenied(table.status())) << std::oct << mode;
    EXPECT_THAT(std::string(table.status().message()), HasSubstr("chmod 0600"));
  }
  for (const mode_t mode : {0600, 0640, 0400}) {
    ASSERT_EQ(chmod(file.c_str(), mode), 0);
    EXPECT_TRUE(TokenTable::Load(file).ok()) << std::oct << mode;
  }
}

}  // namespace
}  // namespace shutterline::server
