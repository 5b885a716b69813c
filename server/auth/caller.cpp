#include "server/auth/caller.h"

#include <absl/strings/str_cat.h>

namespace shutterline::server {

absl::string_view RoleName(Role role) {
  switch (role) {
    case Role::kClient:
      return "client";
    case Role::kWorker:
      return "worker";
    case Role::kAdmin:
      return "admin";
  }
  return "";
}

std::optional<Role> RoleOf(absl::string_view name) {
  for (const Role role : kRoles) {
    if (RoleName(role) == name) return role;
  }
  return std::nullopt;
}

std::string RoleSet::ToString() const {
  std::string text;
  for (const Role role : kRoles) {
    if (Has(role)) absl::StrAppend(&text, text.empty() ? "" : " or ", RoleName(role));
  }
  return text.empty() ? "no role" : text;
}

}  // namespace shutterline::server
