#include "tests/fuzz/fuzz_engine.h"

#include <absl/strings/str_cat.h>

#include <array>
#include <random>

#include "tests/fuzz/hostile_frames.h"
#include "tests/fuzz/kernel_checks.h"
#include "tests/fuzz/resolver_checks.h"

namespace shutterline::engine {
namespace {

constexpr std::array kPatterns{PatternKind::k1h1v, PatternKind::k2h2v,   PatternKind::k4h4v,
                               PatternKind::k8h8v, PatternKind::k16h16v, PatternKind::kRgls};

RenderSettings SettingsOf(uint64_t seed, ResolverKind resolver) {
  std::mt19937_64 random(seed);
  RenderSettings settings;
  settings.pattern = kPatterns[random() % kPatterns.size()];
  settings.resolver = resolver;
  // Dyadic instants. Some follow the motion instead, coarsely.
  settings.time_samples = 1 << (random() % 4);
  if (random() % 16 == 0) {
    settings.time_samples.reset();
    settings.time_step = 64;
  }
  return settings;
}

}  // namespace

std::string FuzzEngine(uint64_t seed) {
  const auto named = [](const char* name, const std::string& broken) {
    return broken.empty() ? broken : absl::StrCat(name, ": ", broken);
  };
  // The kernels cost little beside the resolvers.
  for (uint64_t i = 0; i < 8; ++i) {
    for (const auto& check : {BrokenMarch, BrokenEnvelope, BrokenPlacedSegments}) {
      if (const std::string broken = check(seed * 8 + i); !broken.empty()) {
        return absl::StrCat("kernels with seed ", seed * 8 + i, ": ", broken);
      }
    }
  }
  const HostileFrame any = AnyBits(seed);
  const HostileFrame lattice = OnLattice(seed);
  const HostileFrame curtain = Curtain(seed);
  RenderSettings slice = SettingsOf(seed, ResolverKind::kSlice);
  std::string broken = named("lattice", BrokenSegments(lattice, slice));
  if (broken.empty()) broken = named("any bits", BrokenResolution(any, slice, seed));
  if (broken.empty()) broken = named("curtain", BrokenResolution(curtain, slice, seed));
  if (broken.empty()) broken = named("lattice", BrokenResolution(lattice, slice, seed));
  // The paper's resolver sorts a cell's polygons in a tree: seconds, for some seeds a minute, where triangles
  // of any bits interpenetrate in every cell. So it meets the lattice only.
  const RenderSettings paper = SettingsOf(seed, ResolverKind::kPaper);
  if (broken.empty() && seed % 8 == 0) broken = named("lattice", BrokenResolution(lattice, paper, seed));
  if (broken.empty()) broken = named("any bits", BrokenTargets(any, slice));
  if (broken.empty()) broken = named("curtain", BrokenCurtain(curtain, slice));
  if (broken.empty()) {
    if (!slice.time_samples) slice.time_samples = 4;
    broken = named("lattice", BrokenAgreement(lattice, slice));
  }
  return broken;
}

}  // namespace shutterline::engine
