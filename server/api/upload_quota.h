#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <utility>

namespace shutterline::server {

/// Bytes that uploads in progress have announced, all together. Thread-safe.
class UploadQuota {
 public:
  explicit UploadQuota(uint64_t max_bytes) : max_bytes_(max_bytes) {}

  /// Part of the quota, from a Take that was OK until Release.
  class Share {
   public:
    Share() = default;
    ~Share() { Release(); }
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    /// RESOURCE_EXHAUSTED where so many bytes are not left: the upload may be tried again later. To be
    /// called once.
    absl::Status Take(UploadQuota& quota, uint64_t bytes);
    void Release() {
      if (quota_ != nullptr) std::exchange(quota_, nullptr)->Return(bytes_);
    }

   private:
    UploadQuota* quota_ = nullptr;
    uint64_t bytes_ = 0;
  };

 private:
  void Return(uint64_t bytes);

  const uint64_t max_bytes_;
  absl::Mutex mutex_;
  uint64_t taken_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace shutterline::server
