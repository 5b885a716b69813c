#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "tests/fuzz/fuzz_engine.h"

// engine-fuzz [--seed S] [--seconds N | --count N] [--keep-going]
//
// Throws hostile triangles at the engine's visibility code, seed after seed from S on. Prints the seed of
// what breaks, also where the engine crashes or does not come to an end, and stops there unless told to keep
// going.
namespace {

/// Of processor time, for a machine may be busy. No seed takes a tenth of that; what takes so long does not
/// come to an end.
constexpr time_t kHangSeconds = 120;

void SetTimer(time_t seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

char seed_text[64];  // For the signal handler, which may not format.

void OnSignal(int number) {
  const char* what = number == SIGPROF ? "does not end: " : "crash: ";
  (void)!write(STDOUT_FILENO, what, std::strlen(what));
  (void)!write(STDOUT_FILENO, seed_text, std::strlen(seed_text));
  signal(number, SIG_DFL);
  raise(number);
}

int Usage() {
  std::fprintf(stderr, "usage: engine-fuzz [--seed S] [--seconds N | --count N] [--keep-going]\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  uint64_t seed = 1;
  uint64_t count = UINT64_MAX;
  double seconds = 1e18;
  bool keep_going = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--keep-going") {
      keep_going = true;
    } else if (i + 1 < argc && word == "--seed") {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (i + 1 < argc && word == "--count") {
      count = std::strtoull(argv[++i], nullptr, 10);
    } else if (i + 1 < argc && word == "--seconds") {
      seconds = std::strtod(argv[++i], nullptr);
    } else {
      return Usage();
    }
  }
  if (count == UINT64_MAX && seconds == 1e18) return Usage();
  for (const int number : {SIGPROF, SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGBUS}) signal(number, OnSignal);

  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  uint64_t done = 0;
  uint64_t findings = 0;
  for (; done < count && elapsed() < seconds; ++done, ++seed) {
    std::snprintf(seed_text, sizeof(seed_text), "seed %" PRIu64 "\n", seed);
    SetTimer(kHangSeconds);
    const std::string broken = shutterline::engine::FuzzEngine(seed);
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
