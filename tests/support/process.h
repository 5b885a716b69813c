#pragma once

#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace shutterline {

/// A program that a test runs, with its standard output and error in files. It is killed when this goes
/// away, and when the test program dies. Thread-safe.
class Process {
 public:
  /// Runs `arguments[0]`; its output goes to LOG.out and LOG.err. Null where it cannot be started.
  static std::unique_ptr<Process> Start(const std::vector<std::string>& arguments,
                                        const std::filesystem::path& log);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void Signal(int signal) const;
  /// Waits for the end. The exit status, or 128 + the signal that ended it; nothing if it still runs.
  std::optional<int> Wait(absl::Duration timeout = absl::Minutes(3));
  bool Running() const;

  std::string Output() const;  ///< Standard output so far.
  std::string Errors() const;  ///< Standard error so far.
  int pid() const { return pid_; }

 private:
  Process(int pid, std::filesystem::path log);

  const int pid_;
  const std::filesystem::path log_;
  mutable absl::Mutex mutex_;
  std::optional<int> status_ ABSL_GUARDED_BY(mutex_);
  std::thread reaper_;
};

/// Waits until `done` holds: for what other processes do and offer no event for, as files that appear. Looks
/// every few milliseconds; false once `timeout` is over.
bool WaitUntil(const std::function<bool()>& done, absl::Duration timeout = absl::Minutes(2));

/// The whole file; empty where there is none.
std::string ReadWholeFile(const std::filesystem::path& path);

}  // namespace shutterline
