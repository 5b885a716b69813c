#include "tests/fuzz/fuzz_journal.h"

#include <spdlog/spdlog.h>

#include "tests/fuzz/fuzz_main.h"
#include "tests/support/temporary_folder.h"

// journal-fuzz: opens journals whose segments are damaged. Arguments: see fuzz_main.h; it takes no files.
int main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::off);
  return shutterline::FuzzMain(
      argc, argv, "journal-fuzz",
      [](uint64_t seed) {
        const shutterline::test::TemporaryFolder folder;
        return shutterline::server::FuzzJournal(seed, folder.path());
      },
      nullptr);
}
