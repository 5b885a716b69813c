#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <optional>
#include <string>
#include <vector>

#include "common/asset/digest.h"
#include "server/auth/caller.h"

namespace shutterline::server {

/// The tokens that a coordinator knows, by their SHA-256 alone: whoever reads the file can call nobody.
/// Lines of it, in any order, with comments after '#':
///
///     role name sha256            client alice
///     9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08
///
/// A name is of 1 to 64 letters, digits, '.', '_', '@' and '-'. It may have several tokens, so that a new one
/// can be handed out before the old one goes, but only one role. Immutable, so thread-safe.
class TokenTable {
 public:
  static constexpr int kMaxTokens = 10'000;

  /// INVALID_ARGUMENT naming the line that breaks a rule.
  static absl::StatusOr<TokenTable> Parse(absl::string_view text);
  /// Parse, of a file that others may neither read nor write.
  static absl::StatusOr<TokenTable> Load(const std::string& file);

  /// Whose token it is; nobody where it is unknown. Takes the same time for every token of the same length.
  std::optional<Caller> Find(absl::string_view token) const;
  size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    Caller caller;
    Digest digest;
  };
  std::vector<Entry> entries_;
};

}  // namespace shutterline::server
