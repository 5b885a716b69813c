// tile-result-fuzz: batches of results, translated, and over a stream to a coordinator; see
// fuzz_tile_result.h and fuzz_main.h.
#include <spdlog/spdlog.h>

#include "tests/fuzz/fuzz_main.h"
#include "tests/fuzz/fuzz_tile_result.h"

int main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::off);
  shutterline::ResultStreamFuzzer stream;
  return shutterline::FuzzMain(
      argc, argv, "tile-result-fuzz",
      [&stream](uint64_t seed) {
        std::string broken = shutterline::FuzzTileResult(seed);
        return broken.empty() && seed % 16 == 0 ? stream.Fuzz(seed) : broken;
      },
      shutterline::CheckResultBytes);
}
