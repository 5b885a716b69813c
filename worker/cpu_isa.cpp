#include "worker/cpu_isa.h"

namespace shutterline::worker {

std::string DetectIsa() {
#if defined(__x86_64__)
  // What x86-64-v4 and x86-64-v3 ask for beyond their predecessors, as far as vector code cares.
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    return "avx512";
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "avx2";
  return "x86-64";
#elif defined(__aarch64__)
  return "aarch64";
#else
  return "unknown";
#endif
}

}  // namespace shutterline::worker
