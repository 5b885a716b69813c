#pragma once

#include <absl/strings/string_view.h>

#include <span>

namespace shutterline::server {

/// A file of the dashboard, as it was when the program was built.
struct DashboardFile {
  absl::string_view name, content;
  absl::string_view digest;  ///< SHA-256 in hexadecimal.
};

std::span<const DashboardFile> DashboardFiles();

}  // namespace shutterline::server
