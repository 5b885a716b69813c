#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>

namespace shutterline::server {

/// CRC-32C (Castagnoli, as in iSCSI, RFC 3720) of `data`. Finds damage, not malice.
uint32_t Crc32c(absl::string_view data);

}  // namespace shutterline::server
