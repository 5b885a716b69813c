#pragma once

#include <string>

namespace shutterline::worker {

/// The best class of vector instructions that this machine offers: "x86-64", "avx2" or "avx512" on x86,
/// the architecture's name elsewhere. Found at run time.
std::string DetectIsa();

}  // namespace shutterline::worker
