#pragma once

#include <absl/strings/string_view.h>

#include <vector>

#include "server/auth/caller.h"

namespace shutterline::server {

/// Who may call a method. What the table does not name, nobody may: a test walks the services' descriptors
/// and fails where one of their methods is missing here.
struct MethodRule {
  absl::string_view path;  ///< "/package.Service/Method".
  bool open = false;       ///< Even for callers who do not say who they are.
  RoleSet roles = {};      ///< Otherwise one of these is needed.
};

const std::vector<MethodRule>& MethodTable();

/// The rule for a path; null where there is none.
const MethodRule* FindRule(absl::string_view path);

}  // namespace shutterline::server
