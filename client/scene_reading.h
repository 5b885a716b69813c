#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <future>

#include "client/interrupt.h"
#include "client/options.h"
#include "client/scene_files.h"

namespace shutterline::client {

/// A job's scene as it is read and hashed by a thread of its own: the coordinator can be found, or started,
/// meanwhile.
class SceneReading {
 public:
  /// Begins. `interrupt` may be null, and must outlive this.
  SceneReading(const JobOptions& options, Interrupt* interrupt);
  /// Waits for the file in hand; others are not read.
  ~SceneReading() { stop_ = true; }
  SceneReading(const SceneReading&) = delete;
  SceneReading& operator=(const SceneReading&) = delete;

  /// Waits until all is read; to be called once. What OpenSceneSource and SceneFiles::Read refuse; CANCELLED
  /// after an interrupt, and RESOURCE_EXHAUSTED where memory is not enough.
  absl::StatusOr<SceneFiles> Get() { return scene_.get(); }

 private:
  std::atomic<bool> stop_ = false;
  Interrupt::Guard guard_;
  std::future<absl::StatusOr<SceneFiles>> scene_;  ///< Its destructor waits.
};

}  // namespace shutterline::client
