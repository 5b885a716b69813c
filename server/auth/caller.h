#pragma once

#include <absl/strings/string_view.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace shutterline::server {

/// What somebody is to this farm. An admin is no worker: nobody needs to render as one.
enum class Role : uint8_t { kClient, kWorker, kAdmin };

inline constexpr std::array<Role, 3> kRoles = {Role::kClient, Role::kWorker, Role::kAdmin};

/// "client", "worker", "admin": as in certificates and token files.
absl::string_view RoleName(Role role);
/// The role of that name, if there is one.
std::optional<Role> RoleOf(absl::string_view name);

/// Some roles. A plain value.
class RoleSet {
 public:
  constexpr RoleSet() = default;
  constexpr RoleSet(std::initializer_list<Role> roles) {
    for (const Role role : roles) Add(role);
  }
  constexpr void Add(Role role) { bits_ = uint8_t(bits_ | 1u << unsigned(role)); }
  constexpr bool Has(Role role) const { return (bits_ & 1u << unsigned(role)) != 0; }
  constexpr bool empty() const { return bits_ == 0; }
  constexpr bool Meets(RoleSet other) const { return (bits_ & other.bits_) != 0; }
  /// "client or admin"; "no role" where there is none.
  std::string ToString() const;

 private:
  uint8_t bits_ = 0;
};

/// Who makes a call.
struct Caller {
  /// Of the token, or the certificate's common name. Empty where nobody has to say who he is: then
  /// everything is permitted, and `roles` are all.
  std::string name;
  RoleSet roles;
};

}  // namespace shutterline::server
