#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace shutterline {

/// The main function of a fuzzer:
///
///     NAME [--seed S] [--seconds N | --count N]    mutants, seed after seed from S on
///     NAME FILE...                                 these inputs, as tests/fuzz/corpus holds them
///     NAME --write SEED                            a seed's input to the standard output
///
/// The first two functions return what is broken, or nothing. Prints the seed or file of what breaks, also
/// where the program crashes or a sanitizer ends it, and ends with 1. Without `by_bytes` it takes no files,
/// without `mutant` it writes none.
int FuzzMain(int argc, char** argv, const char* name, const std::function<std::string(uint64_t)>& by_seed,
             const std::function<std::string(const std::string&)>& by_bytes,
             const std::function<std::string(uint64_t)>& mutant = nullptr);

}  // namespace shutterline
