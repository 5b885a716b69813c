#include "server/auth/token_table.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <openssl/crypto.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/base/status_macros.h"
#include "proto/credentials/private_file.h"

namespace shutterline::server {
namespace {

bool IsName(absl::string_view name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return absl::ascii_isalnum(c) || c == '.' || c == '_' || c == '@' || c == '-';
  });
}

}  // namespace

absl::StatusOr<TokenTable> TokenTable::Parse(absl::string_view text) {
  TokenTable table;
  std::map<std::string, Role> roles;
  std::set<Digest> digests;
  int number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    const auto refuse = [number](absl::string_view why) {
      return absl::InvalidArgumentError(absl::StrCat("line ", number, ": ", why));
    };
    line = line.substr(0, line.find('#'));
    const std::vector<absl::string_view> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (words.empty()) continue;
    if (words.size() != 3) return refuse("is not 'role name sha256'");
    const std::optional<Role> role = RoleOf(words[0]);
    if (!role) return refuse("the role must be client, worker or admin");
    if (!IsName(words[1])) {
      return refuse("the name must be 1 to 64 letters, digits and ._@-");
    }
    const absl::StatusOr<Digest> digest = Digest::FromHex(words[2]);
    if (!digest.ok()) return refuse("the last word must be the token's SHA-256, 64 hexadecimal digits");
    if (!digests.insert(*digest).second) return refuse("has the token of another line");
    const std::string name(words[1]);
    if (roles.emplace(name, *role).first->second != *role) {
      return refuse(absl::StrCat("'", name, "' has another role in a line before"));
    }
    if (table.entries_.size() == size_t(kMaxTokens)) {
      return refuse(absl::StrCat("more than ", kMaxTokens, " tokens"));
    }
    table.entries_.push_back({Caller{name, RoleSet{*role}}, *digest});
  }
  if (table.entries_.empty()) return absl::InvalidArgumentError("names no token, so nobody could call");
  return table;
}

absl::StatusOr<TokenTable> TokenTable::Load(const std::string& file) {
  SL_ASSIGN_OR_RETURN(const std::string text,
                      credentials::ReadPrivateFile(file, "the token table", credentials::Secrecy::kSecret));
  absl::StatusOr<TokenTable> table = Parse(text);
  if (!table.ok()) return Annotate(table.status(), file);
  return table;
}

std::optional<Caller> TokenTable::Find(absl::string_view token) const {
  const Digest digest = Sha256(token);
  const Entry* found = nullptr;
  for (const Entry& entry : entries_) {  // To the end, also after a hit.
    if (CRYPTO_memcmp(entry.digest.bytes.data(), digest.bytes.data(), digest.bytes.size()) == 0)
      found = &entry;
  }
  if (found == nullptr) return std::nullopt;
  return found->caller;
}

}  // namespace shutterline::server
