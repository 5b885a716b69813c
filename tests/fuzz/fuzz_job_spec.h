#pragma once

#include <cstdint>
#include <string>

namespace shutterline {

/// Bytes to v1::JobSpec to JobSpec and back: what is taken must be valid, and come out equal; the rest must
/// be refused with INVALID_ARGUMENT and a reason. Returns what is broken, or nothing.
std::string CheckJobSpecBytes(const std::string& bytes);

/// CheckJobSpecBytes of a mutant that `seed` makes of a valid specification.
std::string FuzzJobSpec(uint64_t seed);

}  // namespace shutterline
