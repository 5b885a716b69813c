#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include <memory>
#include <utility>

#include "common/asset/digest.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Where one part of a process leaves the scene that it has imported for another, which need not read the
/// same files again: a coordinator that checks a job's scene, for a worker beside it. Holds one scene, the
/// latest, until it is taken. Thread-safe.
class SceneShelf {
 public:
  /// `key` tells scenes of different files apart, as PictureKey does.
  void Put(const Digest& key, std::shared_ptr<const Scene> scene) {
    absl::MutexLock lock(&mutex_);
    key_ = key;
    scene_.swap(scene);  // The one that lay here is freed by the caller, without the lock.
  }
  /// Null where another scene lies here, or none.
  std::shared_ptr<const Scene> Take(const Digest& key) {
    absl::MutexLock lock(&mutex_);
    return key == key_ ? std::exchange(scene_, nullptr) : nullptr;
  }

 private:
  absl::Mutex mutex_;
  Digest key_ ABSL_GUARDED_BY(mutex_) = {};
  std::shared_ptr<const Scene> scene_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::engine
