#include <spdlog/spdlog.h>

#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/fuzz/fuzz_journal.h"
#include "tests/support/temporary_folder.h"

// journal-fuzz [--seed S] [--seconds N | --count N]
//
// Opens journals whose segments are damaged, seed after seed from S on; stops at the first seed with which
// something is wrong, and prints it. Before each seed its number stands in the file journal-fuzz-seed of the
// working folder, for the case that it crashes.
int main(int argc, char** argv) {
  uint64_t seed = 1, count = UINT64_MAX;
  double seconds = 1e18;
  for (int i = 1; i < argc; i += 2) {
    const std::string word = argv[i];
    if (i + 1 < argc && word == "--seed") {
      seed = std::strtoull(argv[i + 1], nullptr, 10);
    } else if (i + 1 < argc && word == "--count") {
      count = std::strtoull(argv[i + 1], nullptr, 10);
    } else if (i + 1 < argc && word == "--seconds") {
      seconds = std::strtod(argv[i + 1], nullptr);
    } else {
      std::fprintf(stderr, "usage: journal-fuzz [--seed S] [--seconds N | --count N]\n");
      return 2;
    }
  }
  if (count == UINT64_MAX && seconds == 1e18) seconds = 10;
  spdlog::set_level(spdlog::level::off);
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  uint64_t done = 0;
  for (; done < count && elapsed() < seconds; ++done, ++seed) {
    if (FILE* const note = std::fopen("journal-fuzz-seed", "w")) {
      std::fprintf(note, "%" PRIu64 "\n", seed);
      std::fclose(note);
    }
    const shutterline::test::TemporaryFolder folder;
    const std::string broken = shutterline::server::FuzzJournal(seed, folder.path());
    if (broken.empty()) continue;
    std::printf("seed %" PRIu64 ": %s\n", seed, broken.c_str());
    return 1;
  }
  std::remove("journal-fuzz-seed");
  std::printf("%" PRIu64 " seeds up to %" PRIu64 " in %.0f s: nothing wrong\n", done, seed - 1, elapsed());
  return 0;
}
