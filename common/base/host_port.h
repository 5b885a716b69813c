#pragma once

#include <absl/strings/string_view.h>

namespace shutterline {

/// The host of "HOST:PORT", without the brackets of IPv6.
absl::string_view HostOf(absl::string_view host_port);

/// Whether `host` (a name or an address, without brackets) can be nothing but this machine: "localhost",
/// 127.x.x.x or ::1. Names are not looked up.
bool IsLoopback(absl::string_view host);

}  // namespace shutterline
