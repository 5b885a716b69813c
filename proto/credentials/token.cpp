#include "proto/credentials/token.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <algorithm>

#include "common/base/status_macros.h"
#include "proto/credentials/private_file.h"

namespace shutterline::credentials {

absl::Status CheckToken(absl::string_view token) {
  if (token.size() < kMinTokenBytes || token.size() > kMaxTokenBytes) {
    return absl::InvalidArgumentError(absl::StrCat("the token has ", token.size(),
                                                   " characters, but must have ", kMinTokenBytes, " to ",
                                                   kMaxTokenBytes));
  }
  const bool well_formed = std::all_of(token.begin(), token.end(), [](unsigned char c) {
    return absl::ascii_isalnum(c) || absl::string_view("-._~+/=").find(char(c)) != absl::string_view::npos;
  });
  if (well_formed) return absl::OkStatus();
  return absl::InvalidArgumentError("the token has other characters than letters, digits and -._~+/=");
}

absl::StatusOr<std::string> LoadToken(const std::string& file) {
  SL_ASSIGN_OR_RETURN(std::string token, ReadPrivateFile(file, "the token", Secrecy::kSecret));
  absl::StripTrailingAsciiWhitespace(&token);
  SL_RETURN_IF_ERROR(Annotate(CheckToken(token), file));
  return token;
}

}  // namespace shutterline::credentials
