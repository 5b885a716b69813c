// Short runs of job-spec-fuzz and tile-result-fuzz, and the inputs of tests/fuzz/corpus.
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "tests/fuzz/fuzz_job_spec.h"
#include "tests/fuzz/fuzz_tile_result.h"

namespace shutterline {
namespace {

void RunFor(int seconds, const std::function<std::string(uint64_t)>& fuzz) {
  using Steady = std::chrono::steady_clock;
  const auto stop = Steady::now() + std::chrono::seconds(seconds);
  for (uint64_t seed = 1; seed <= 100 || Steady::now() < stop; ++seed)
    ASSERT_EQ(fuzz(seed), "") << "seed " << seed;
}

void CheckCorpus(const std::string& name, const std::function<std::string(const std::string&)>& check) {
  const auto folder = std::filesystem::path(SHUTTERLINE_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / name;
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream stream(entry.path(), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    EXPECT_EQ(check(bytes), "") << entry.path();
    ++files;
  }
  EXPECT_GT(files, 0);
}

TEST(MessageFuzz, JobSpecs) {
  CheckCorpus("job_spec", CheckJobSpecBytes);
  RunFor(2, FuzzJobSpec);
}

TEST(MessageFuzz, TileResults) {
  CheckCorpus("tile_result", CheckResultBytes);
  RunFor(2, FuzzTileResult);
}

TEST(MessageFuzz, ResultStreams) {
  spdlog::set_level(spdlog::level::off);
  ResultStreamFuzzer stream;
  RunFor(3, [&](uint64_t seed) { return stream.Fuzz(seed); });
}

}  // namespace
}  // namespace shutterline
