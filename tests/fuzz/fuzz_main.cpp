#include "tests/fuzz/fuzz_main.h"

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

/// Of the sanitizers, where a program has one: called before it ends the program.
extern "C" [[gnu::weak]] void __sanitizer_set_death_callback(void (*callback)());

namespace shutterline {
namespace {

char current_input[256];  // For the signal handler, which may not format.

void TellInput() {
  (void)!write(STDOUT_FILENO, "crash: ", 7);
  (void)!write(STDOUT_FILENO, current_input, std::strlen(current_input));
}

void OnCrash(int number) {
  TellInput();
  signal(number, SIG_DFL);
  raise(number);
}

int FuzzUsage(const char* name) {
  std::fprintf(stderr, "usage: %s [--seed S] [--seconds N | --count N] | %s FILE...\n", name, name);
  return 2;
}

}  // namespace

int FuzzMain(int argc, char** argv, const char* name, const std::function<std::string(uint64_t)>& by_seed,
             const std::function<std::string(const std::string&)>& by_bytes,
             const std::function<std::string(uint64_t)>& mutant) {
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(TellInput);
  for (const int number : {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS}) signal(number, OnCrash);
  if (argc == 3 && std::strcmp(argv[1], "--write") == 0 && mutant) {
    const std::string bytes = mutant(std::strtoull(argv[2], nullptr, 10));
    return std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size() ? 0 : 1;
  }
  if (argc > 1 && argv[1][0] != '-') {
    if (!by_bytes) return FuzzUsage(name);
    int findings = 0;
    for (int i = 1; i < argc; ++i) {
      std::snprintf(current_input, sizeof current_input, "%s\n", argv[i]);
      std::ifstream stream(argv[i], std::ios::binary);
      if (!stream) return FuzzUsage(name);
      const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
      const std::string broken = by_bytes(bytes);
      if (broken.empty()) continue;
      std::printf("%s: %s\n", argv[i], broken.c_str());
      ++findings;
    }
    return findings == 0 ? 0 : 1;
  }
  uint64_t seed = 1, count = 0;
  double seconds = 0;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    if (word == "--seed") {
      seed = std::strtoull(argv[i + 1], nullptr, 10);
    } else if (word == "--count") {
      count = std::strtoull(argv[i + 1], nullptr, 10);
    } else if (word == "--seconds") {
      seconds = std::strtod(argv[i + 1], nullptr);
    } else {
      return FuzzUsage(name);
    }
  }
  if (argc % 2 == 0 || (count == 0) == (seconds <= 0)) return FuzzUsage(name);
  using Steady = std::chrono::steady_clock;
  const auto start = Steady::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Steady::now() - start).count(); };
  uint64_t done = 0;
  for (; count > 0 ? done < count : elapsed() < seconds; ++done, ++seed) {
    std::snprintf(current_input, sizeof current_input, "seed %" PRIu64 "\n", seed);
    const std::string broken = by_seed(seed);
    if (broken.empty()) continue;
    std::printf("seed %" PRIu64 ": %s\n", seed, broken.c_str());
    return 1;
  }
  std::printf("%" PRIu64 " seeds up to %" PRIu64 " in %.0f s: nothing broke\n", done, seed - 1, elapsed());
  return 0;
}

}  // namespace shutterline
