#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace shutterline {

/// The main function of a fuzzer:
///
///     NAME [--seed S] [--seconds N] [--count N] [--keep-going]    seed after seed from S on, until one of
///     both NAME FILE...                                 these inputs, as tests/fuzz/corpus holds them NAME
///     --write SEED                            a seed's input to the standard output
///
/// The first two functions return what is broken, or nothing. Prints the seed or file of what breaks, also
/// where the program crashes, does not come to an end or is ended by a sanitizer, and ends with 1; at the
/// first such seed unless told to keep going. Without `by_bytes` it takes no files, without `mutant` it
/// writes none.
int FuzzMain(int argc, char** argv, const char* name, const std::function<std::string(uint64_t)>& by_seed,
             const std::function<std::string(const std::string&)>& by_bytes,
             const std::function<std::string(uint64_t)>& mutant = nullptr);

}  // namespace shutterline
