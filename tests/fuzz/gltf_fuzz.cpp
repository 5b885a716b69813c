#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz_main.h"
#include "tests/support/gltf_mutator.h"
#include "tests/support/gltf_seeds.h"
#include "tests/support/scene_invariants.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"

namespace shutterline {
namespace {

/// What promise of scene.h an imported scene breaks.
std::string Import(const std::string& bytes) {
  engine::ImportLimits limits;
  limits.base_memory = uint64_t{64} << 20;
  limits.max_texture_pixels = 1 << 20;
  const auto scene =
      engine::ImportGltf(engine::MemoryAssetSource("mutant.glb", {{"mutant.glb", bytes}}), limits);
  return scene.ok() ? engine::BrokenSceneInvariant(**scene) : "";
}

}  // namespace
}  // namespace shutterline

// gltf-fuzz: imports mutants of small valid files, or files. Arguments: see fuzz_main.h.
int main(int argc, char** argv) {
  using namespace shutterline;
  const std::vector<GltfBuilder> seeds = GltfSeeds();
  const auto mutant = [&](uint64_t seed) {
    std::mt19937_64 random(seed);
    return MutateGltf(seeds[seed % seeds.size()], &random);
  };
  return FuzzMain(
      argc, argv, "gltf-fuzz", [&](uint64_t seed) { return Import(mutant(seed)); }, Import, mutant);
}
