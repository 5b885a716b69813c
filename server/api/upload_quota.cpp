#include "server/api/upload_quota.h"

#include <absl/strings/str_cat.h>

namespace shutterline::server {

absl::Status UploadQuota::Share::Take(UploadQuota& quota, uint64_t bytes) {
  absl::MutexLock lock(&quota.mutex_);
  if (bytes > quota.max_bytes_ - quota.taken_) {
    return absl::ResourceExhaustedError(absl::StrCat("uploads in progress may announce ", quota.max_bytes_,
                                                     " bytes together, of which ", quota.taken_,
                                                     " are taken; this one has ", bytes));
  }
  quota.taken_ += bytes;
  quota_ = &quota;
  bytes_ = bytes;
  return absl::OkStatus();
}

void UploadQuota::Return(uint64_t bytes) {
  absl::MutexLock lock(&mutex_);
  taken_ -= bytes;
}

}  // namespace shutterline::server
