#include "worker/memory_limit.h"

#include <absl/strings/str_cat.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>

namespace shutterline::worker {

absl::Status LimitMemory(uint64_t bytes) {
  // RLIMIT_AS would count what is only reserved, as allocators do by the gigabyte.
  rlimit limit{};
  if (getrlimit(RLIMIT_DATA, &limit) != 0) return absl::ErrnoToStatus(errno, "ask for the limit of memory");
  limit.rlim_cur = std::min(rlim_t(bytes), limit.rlim_max);
  if (setrlimit(RLIMIT_DATA, &limit) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("limit memory to ", bytes, " bytes"));
  }
  return absl::OkStatus();
}

}  // namespace shutterline::worker
