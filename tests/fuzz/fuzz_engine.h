#pragma once

#include <cstdint>
#include <string>

namespace shutterline::engine {

/// One round of every check on inputs made from `seed`. Returns what is broken, with the check's name, or
/// nothing.
std::string FuzzEngine(uint64_t seed);

}  // namespace shutterline::engine
