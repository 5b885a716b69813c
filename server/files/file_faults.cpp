#include "server/files/file_faults.h"

#include <atomic>

namespace shutterline::server {
namespace {

std::atomic<FileFaults*> installed{nullptr};

}  // namespace

void InstallFileFaults(FileFaults* faults) {
  installed.store(faults);
}

FileFaults::Verdict AskFileFaults(const FileOperation& operation) {
  FileFaults* const faults = installed.load(std::memory_order_acquire);
  return faults == nullptr ? FileFaults::Verdict{} : faults->Before(operation);
}

}  // namespace shutterline::server
