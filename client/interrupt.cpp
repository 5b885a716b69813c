#include "client/interrupt.h"

#include <fcntl.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <thread>
#include <utility>

#include "common/base/check.h"

namespace shutterline::client {
namespace {

/// The write end of the watcher's pipe: all that a signal handler may touch.
volatile int signal_pipe = -1;
/// When the first signal came, seconds of the monotonic clock; 0: none yet.
volatile time_t first_signal = 0;

extern "C" void OnSignal(int signal) {
  const int saved = errno;
  struct timespec now {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (first_signal == 0) {
    first_signal = now.tv_sec;
  } else if (now.tv_sec - first_signal >= 2) {
    // A second wish, not the echo of the first: `timeout` and shells signal a program and its group.
    struct sigaction fall_back {};
    fall_back.sa_handler = SIG_DFL;
    sigaction(signal, &fall_back, nullptr);
    raise(signal);
  }
  const char byte = 's';
  // A full pipe means that the wish is known already.
  [[maybe_unused]] const ssize_t written = write(signal_pipe, &byte, 1);
  errno = saved;
}

}  // namespace

bool Interrupt::raised() const {
  absl::MutexLock lock(&mutex_);
  return raised_;
}

void Interrupt::Raise() {
  absl::MutexLock lock(&mutex_);
  if (raised_) return;
  raised_ = true;
  for (const auto& [guard, action] : actions_) action();
}

void Interrupt::WaitFor(absl::Duration duration) {
  absl::MutexLock lock(&mutex_);
  mutex_.AwaitWithTimeout(absl::Condition(&raised_), duration);
}

Interrupt::Guard::Guard(Interrupt* interrupt, std::function<void()> action) : interrupt_(interrupt) {
  if (interrupt_ == nullptr) return;
  absl::MutexLock lock(&interrupt_->mutex_);
  if (interrupt_->raised_) action();
  interrupt_->actions_.emplace(this, std::move(action));
}

Interrupt::Guard::~Guard() {
  if (interrupt_ == nullptr) return;
  absl::MutexLock lock(&interrupt_->mutex_);
  interrupt_->actions_.erase(this);
}

struct SignalInterrupt::Watcher {
  int read_end = -1, write_end = -1;
  struct sigaction old_int {
  }, old_term{};
  std::thread thread;
};

SignalInterrupt::SignalInterrupt(Interrupt& interrupt) : watcher_(std::make_unique<Watcher>()) {
  SL_CHECK(signal_pipe == -1);
  int ends[2];
  SL_CHECK(pipe2(ends, O_CLOEXEC) == 0);
  watcher_->read_end = ends[0];
  watcher_->write_end = ends[1];
  signal_pipe = ends[1];
  watcher_->thread = std::thread([this, &interrupt] {
    char byte = 0;
    ssize_t got;
    do {
      got = read(watcher_->read_end, &byte, 1);
    } while (got < 0 && errno == EINTR);
    if (got == 1 && byte == 's') interrupt.Raise();
  });
  struct sigaction action {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESTART;
  first_signal = 0;
  sigaction(SIGINT, &action, &watcher_->old_int);
  sigaction(SIGTERM, &action, &watcher_->old_term);
}

SignalInterrupt::~SignalInterrupt() {
  sigaction(SIGINT, &watcher_->old_int, nullptr);
  sigaction(SIGTERM, &watcher_->old_term, nullptr);
  const char byte = 'q';
  SL_CHECK(write(watcher_->write_end, &byte, 1) == 1);
  watcher_->thread.join();
  signal_pipe = -1;
  close(watcher_->read_end);
  close(watcher_->write_end);
}

}  // namespace shutterline::client
