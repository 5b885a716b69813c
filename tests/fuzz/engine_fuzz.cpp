#include "tests/fuzz/fuzz_engine.h"
#include "tests/fuzz/fuzz_main.h"

// engine-fuzz: throws hostile triangles at the engine's visibility code. Arguments: see fuzz_main.h; it takes
// no files.
int main(int argc, char** argv) {
  return shutterline::FuzzMain(argc, argv, "engine-fuzz", shutterline::engine::FuzzEngine, nullptr);
}
