#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <functional>
#include <map>
#include <memory>

namespace shutterline::client {

/// The user's wish to stop, as an object that waiting code can ask, wait on and be called back by.
/// Thread-safe.
class Interrupt {
 public:
  Interrupt() = default;
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool raised() const;
  /// From then on raised; runs the actions of every live Guard. Later calls do nothing.
  void Raise();
  /// Returns when raised or after `duration`.
  void WaitFor(absl::Duration duration);

  /// Runs `action` when the interrupt is raised, at once if it is already; not any more, and not still,
  /// once the guard's destructor has returned. `action` must be quick and must not use the interrupt.
  class Guard {
   public:
    Guard(Interrupt* interrupt, std::function<void()> action);
    ~Guard();
    Guard(const Guard&) = delete;
    Guard& operator=(const Guard&) = delete;

   private:
    Interrupt* const interrupt_;  ///< May be null: then nothing ever runs.
  };

 private:
  mutable absl::Mutex mutex_;
  bool raised_ ABSL_GUARDED_BY(mutex_) = false;
  std::map<const Guard*, std::function<void()>> actions_ ABSL_GUARDED_BY(mutex_);
};

/// While it lives, the first SIGINT or SIGTERM raises `interrupt` and a second one, two seconds later or
/// more, ends the process as if it had not been handled. One at a time in a process.
class SignalInterrupt {
 public:
  explicit SignalInterrupt(Interrupt& interrupt);
  ~SignalInterrupt();
  SignalInterrupt(const SignalInterrupt&) = delete;
  SignalInterrupt& operator=(const SignalInterrupt&) = delete;

 private:
  struct Watcher;
  std::unique_ptr<Watcher> watcher_;
};

}  // namespace shutterline::client
