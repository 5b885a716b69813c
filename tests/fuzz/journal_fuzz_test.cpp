// A short run of journal-fuzz, over seeds of its own.
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include "tests/fuzz/fuzz_journal.h"
#include "tests/support/rounds.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::server {
namespace {

TEST(JournalFuzz, NothingBreaksInAShortRun) {
  spdlog::set_level(spdlog::level::off);
  for (uint64_t seed = 1'000'000'000; seed < 1'000'000'000 + uint64_t(Rounds(400)); ++seed) {
    const test::TemporaryFolder folder;
    ASSERT_EQ(FuzzJournal(seed, folder.path()), "") << "journal-fuzz --seed " << seed << " --count 1";
  }
  spdlog::set_level(spdlog::level::info);
}

}  // namespace
}  // namespace shutterline::server
