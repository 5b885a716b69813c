#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "tests/support/gltf_mutator.h"
#include "tests/support/gltf_seeds.h"
#include "tests/support/scene_invariants.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"

// gltf-fuzz --seed N --count M   imports M mutants of small valid files
// gltf-fuzz FILE...              imports these files, as a mutant that has crashed once
//
// A crash leaves its file as gltf-fuzz-crash.bin in the working folder.
namespace {

using namespace shutterline;

const char kCrashFile[] = "gltf-fuzz-crash.bin";

/// False where an imported scene breaks a promise of scene.h.
bool Import(const std::string& bytes, const std::string& name, bool verbose) {
  engine::ImportLimits limits;
  limits.base_memory = uint64_t{64} << 20;
  limits.max_texture_pixels = 1 << 20;
  const auto scene = engine::ImportGltf(engine::MemoryAssetSource(name, {{name, bytes}}), limits);
  const std::string broken = scene.ok() ? engine::BrokenSceneInvariant(**scene) : "";
  if (verbose || !broken.empty()) {
    std::printf("%s: %s%s%s\n", name.c_str(), scene.status().ToString().c_str(),
                broken.empty() ? "" : ": broken: ", broken.c_str());
  }
  return broken.empty();
}

void Write(const std::string& bytes) {
  std::ofstream(kCrashFile, std::ios::binary | std::ios::trunc)
      .write(bytes.data(), std::streamsize(bytes.size()));
}

int RunMutants(uint64_t seed, uint64_t count) {
  const std::vector<GltfBuilder> seeds = GltfSeeds();
  for (uint64_t i = 0; i < count; ++i) {
    std::mt19937_64 random(seed + i);
    const std::string file = MutateGltf(seeds[i % seeds.size()], &random);
    Write(file);  // Before the import: a crash leaves no time after it.
    if (!Import(file, "mutant.glb", false)) {
      std::printf("seed %llu\n", static_cast<unsigned long long>(seed + i));
      return 1;
    }
  }
  std::remove(kCrashFile);
  std::printf("%llu mutants from seed %llu: no crash\n", static_cast<unsigned long long>(count),
              static_cast<unsigned long long>(seed));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 5 && std::string(argv[1]) == "--seed" && std::string(argv[3]) == "--count") {
    return RunMutants(std::strtoull(argv[2], nullptr, 10), std::strtoull(argv[4], nullptr, 10));
  }
  if (argc < 2 || argv[1][0] == '-') {
    std::fprintf(stderr, "usage: gltf-fuzz --seed N --count M | gltf-fuzz FILE...\n");
    return 2;
  }
  bool whole = true;
  for (int i = 1; i < argc; ++i) {
    std::ifstream stream(argv[i], std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    whole = Import(bytes, "file.glb", true) && whole;
  }
  return whole ? 0 : 1;
}
