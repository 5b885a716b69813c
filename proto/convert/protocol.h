#pragma once

#include <cstdint>

namespace shutterline::convert {

/// Versions of the protocol that this build speaks, both included. A change that an older peer would
/// misunderstand takes a new number.
inline constexpr uint32_t kProtocolLow = 1;
inline constexpr uint32_t kProtocolHigh = 1;

}  // namespace shutterline::convert
