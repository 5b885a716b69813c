#include "tests/bench/machine.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>

#include <fstream>
#include <thread>

namespace shutterline::bench {
namespace {

const char* VectorInstructions() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) return "AVX-512";
  if (__builtin_cpu_supports("avx2")) return "AVX2";
  return "SSE2";
#else
  return "not x86";
#endif
}

}  // namespace

std::string MachineName() {
  std::ifstream file("/proc/cpuinfo");
  std::string line, name = "unknown processor";
  while (std::getline(file, line)) {
    const size_t colon = line.find(": ");
    if (line.rfind("model name", 0) != 0 || colon == std::string::npos) continue;
    name = line.substr(colon + 2);
    break;
  }
  return absl::StrCat(name, ", ", std::thread::hardware_concurrency(), " cores, ", VectorInstructions());
}

std::string MachineLoad() {
  std::ifstream file("/proc/loadavg");
  std::string one, five, fifteen;
  file >> one >> five >> fifteen;
  return absl::StrCat(one, " ", five, " ", fifteen);
}

}  // namespace shutterline::bench
