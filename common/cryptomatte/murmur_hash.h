#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>

namespace shutterline {

/// MurmurHash3, the variant of 32 bits for x86 with seed 0, which Cryptomatte asks for. Equal on all
/// machines.
uint32_t MurmurHash3(absl::string_view bytes);

}  // namespace shutterline
