#include "tests/fuzz/fuzz_main.h"

#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

/// Of the sanitizers, where a program has one: called before it ends the program.
extern "C" [[gnu::weak]] void __sanitizer_set_death_callback(void (*callback)());

namespace shutterline {
namespace {

char current_input[256];  // For the signal handler, which may not format.

void Tell(const char* what) {
  (void)!write(STDOUT_FILENO, what, std::strlen(what));
  (void)!write(STDOUT_FILENO, current_input, std::strlen(current_input));
}

void OnDeath() {
  Tell("crash: ");
}

/// Of processor time, for a machine may be busy. No input takes a tenth of that; what takes so long does not
/// come to an end.
constexpr time_t kHangSeconds = 120;

void SetTimer(time_t seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

void OnSignal(int number) {
  Tell(number == SIGPROF ? "does not end: " : "crash: ");
  signal(number, SIG_DFL);
  raise(number);
}

int FuzzUsage(const char* name) {
  std::fprintf(stderr, "usage: %s [--seed S] [--seconds N] [--count N] [--keep-going] | %s FILE...\n", name,
               name);
  return 2;
}

}  // namespace

int FuzzMain(int argc, char** argv, const char* name, const std::function<std::string(uint64_t)>& by_seed,
             const std::function<std::string(const std::string&)>& by_bytes,
             const std::function<std::string(uint64_t)>& mutant) {
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(OnDeath);
  for (const int number : {SIGPROF, SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS}) signal(number, OnSignal);
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
      SetTimer(kHangSeconds);
      const std::string broken = by_bytes(bytes);
      if (broken.empty()) continue;
      std::printf("%s: %s\n", argv[i], broken.c_str());
      ++findings;
    }
    return findings == 0 ? 0 : 1;
  }
  uint64_t seed = 1, count = std::numeric_limits<uint64_t>::max();
  double seconds = std::numeric_limits<double>::infinity();
  bool is_bounded = false, keep_going = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--keep-going") {
      keep_going = true;
    } else if (i + 1 == argc) {
      return FuzzUsage(name);
    } else if (word == "--seed") {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (word == "--count") {
      count = std::strtoull(argv[++i], nullptr, 10);
      is_bounded = true;
    } else if (word == "--seconds") {
      seconds = std::strtod(argv[++i], nullptr);
      is_bounded = true;
    } else {
      return FuzzUsage(name);
    }
  }
  if (!is_bounded) return FuzzUsage(name);
  using Steady = std::chrono::steady_clock;
  const auto start = Steady::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Steady::now() - start).count(); };
  uint64_t done = 0, findings = 0;
  for (; done < count && elapsed() < seconds; ++done, ++seed) {
    std::snprintf(current_input, sizeof current_input, "seed %" PRIu64 "\n", seed);
    SetTimer(kHangSeconds);
    const std::string broken = by_seed(seed);
    if (broken.empty()) continue;
    ++findings;
    std::printf("seed %" PRIu64 ": %s\n", seed, broken.c_str());
    std::fflush(stdout);
    if (!keep_going) return 1;
  }
  SetTimer(0);
  std::printf("%" PRIu64 " seeds up to %" PRIu64 " in %.0f s: %" PRIu64 " findings\n", done, seed - 1,
              elapsed(), findings);
  return findings == 0 ? 0 : 1;
}

}  // namespace shutterline
