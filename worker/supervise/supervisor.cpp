#include "worker/supervise/supervisor.h"

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <fcntl.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <optional>
#include <utility>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "worker/supervise/log_tail.h"

namespace shutterline::worker {
namespace {

constexpr size_t kToldExits = 4;
constexpr char kDrain = 'd', kLeave = 'q';

/// Closes what it holds.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  ~Descriptor() { Close(); }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  int get() const { return fd_; }
  int Release() { return std::exchange(fd_, -1); }
  void Close() {
    if (fd_ >= 0) close(std::exchange(fd_, -1));
  }

 private:
  int fd_;
};

void WriteAll(int fd, const char* bytes, size_t count) {
  while (count > 0) {
    const ssize_t written = write(fd, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // Nobody reads our log any more: the worker goes on.
    bytes += written;
    count -= size_t(written);
  }
}

class Supervisor {
 public:
  Supervisor(const SupervisorOptions& options, RenderingTable& table,
             const std::function<int(const Supervised&)>& work)
      : options_(options), table_(table), work_(work), delay_(options.backoff_initial) {}

  int Run() {
    if (const absl::Status ready = TakeSignals(); !ready.ok()) return Fail(ready);
    while (true) {
      const absl::Duration start = Now();
      if (const absl::Status started = Start(); !started.ok()) return Fail(started);
      const int status = Watch();
      if (WIFEXITED(status)) return WEXITSTATUS(status);
      const int signal = WTERMSIG(status);
      if (orders_given_ > 0) return EndBy(signal);
      Note(signal);
      if (Now() - start > options_.healthy_after) delay_ = options_.backoff_initial;
      spdlog::error("worker process died and is started again signal={} pid={} delay_ms={}", signal, child_,
                    absl::ToInt64Milliseconds(delay_));
      if (!Pause()) return 0;
      delay_ = std::min(2 * delay_, options_.backoff_max);
    }
  }

 private:
  static absl::Duration Now() { return Clock::System().Monotonic(); }
  static int Fail(const absl::Status& status) {
    spdlog::error("worker cannot be supervised reason={}", LogValue(status.message()));
    return 1;
  }

  /// They are read from a descriptor from now on.
  absl::Status TakeSignals() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGTERM, SIGINT, SIGCHLD}) sigaddset(&signals, signal);
    sigprocmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGCHLD,
                SIG_DFL);  // Ignored, as some launchers leave it, it would not tell of a child's end.
    signals_ = Descriptor(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
    return signals_.get() < 0 ? absl::ErrnoToStatus(errno, "signalfd") : absl::OkStatus();
  }

  absl::Status Start() {
    std::array<int, 2> log{}, orders{};
    if (pipe2(log.data(), O_CLOEXEC) != 0) return absl::ErrnoToStatus(errno, "pipe");
    log_ = Descriptor(log[0]);
    Descriptor log_end(log[1]);
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, orders.data()) != 0) {
      return absl::ErrnoToStatus(errno, "socketpair");
    }
    orders_ = Descriptor(orders[0]);
    Descriptor orders_end(orders[1]);
    boot_id_ = MakeUuid();
    tail_.Clear();
    (void)table_.Take();
    std::fflush(nullptr);  // Or the child would write it again.
    const pid_t parent = getpid();
    child_ = fork();
    if (child_ < 0) return absl::ErrnoToStatus(errno, "fork");
    if (child_ == 0) BeTheWorker(parent, log_end.get(), orders_end.Release());
    fcntl(log_.get(), F_SETFL, O_NONBLOCK);
    return absl::OkStatus();
  }

  [[noreturn]] void BeTheWorker(pid_t parent, int log_end, int orders) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);  // It died before it was asked to take us along.
    dup2(log_end, STDERR_FILENO);
    close(log_end);
    log_.Close();
    orders_.Close();
    signals_.Close();
    std::signal(SIGPIPE, SIG_DFL);
    sigset_t child_ended;
    sigemptyset(&child_ended);
    sigaddset(&child_ended, SIGCHLD);
    sigprocmask(SIG_UNBLOCK, &child_ended, nullptr);
    const int status = work_({boot_id_, exits_, orders});
    std::fflush(nullptr);
    _exit(status);
  }

  /// Until the process has ended: its status, as waitpid says it.
  int Watch() {
    while (true) {
      std::array<pollfd, 2> fds{{{signals_.get(), POLLIN, 0}, {log_.get(), POLLIN, 0}}};
      if (poll(fds.data(), log_.get() < 0 ? 1 : 2, -1) < 0 && errno != EINTR) {
        spdlog::error("worker cannot be watched errno={}", errno);
        _exit(1);  // It goes with us.
      }
      if (fds[1].revents != 0) PassLogOn();
      while (const std::optional<int> signal = NextSignal()) {
        if (*signal != SIGCHLD) GiveOrder(*signal);
      }
      if (const std::optional<int> status = Ended()) {
        PassLogOn();
        return *status;
      }
    }
  }

  std::optional<int> NextSignal() {
    signalfd_siginfo info;
    if (read(signals_.get(), &info, sizeof info) != sizeof info) return std::nullopt;
    return int(info.ssi_signo);
  }

  void GiveOrder(int signal) {
    const char order = orders_given_++ == 0 ? kDrain : kLeave;
    spdlog::info("worker is told to {} signal={}", order == kDrain ? "drain" : "leave at once", signal);
    // One that has just ended needs no orders.
    (void)send(orders_.get(), &order, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
  }

  /// Where we are the first process of a container, there may be orphans of others, too.
  std::optional<int> Ended() {
    std::optional<int> status;
    int one = 0;
    for (pid_t pid = 0; (pid = waitpid(-1, &one, WNOHANG)) > 0;) {
      if (pid == child_) status = one;
    }
    return status;
  }

  void PassLogOn() {
    std::array<char, 65536> bytes;
    while (log_.get() >= 0) {
      const ssize_t count = read(log_.get(), bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return;
      if (count == 0) return log_.Close();
      WriteAll(STDERR_FILENO, bytes.data(), size_t(count));
      tail_.Add({bytes.data(), size_t(count)});
    }
  }

  void Note(int signal) {
    if (exits_.size() == kToldExits) exits_.erase(exits_.begin());
    exits_.push_back({boot_id_, signal, tail_.Text(), table_.Take()});
  }

  /// False where we are told to leave meanwhile.
  bool Pause() {
    const absl::Duration until = Now() + delay_;
    while (Now() < until) {
      pollfd fd{signals_.get(), POLLIN, 0};
      poll(&fd, 1, int(absl::ToInt64Milliseconds(until - Now())) + 1);
      while (const std::optional<int> signal = NextSignal()) {
        if (*signal != SIGCHLD) return false;
      }
    }
    return true;
  }

  /// As the worker's process ended, so do we.
  static int EndBy(int signal) {
    std::signal(signal, SIG_DFL);
    sigset_t one;
    sigemptyset(&one);
    sigaddset(&one, signal);
    prctl(PR_SET_DUMPABLE, 0);  // One core is enough.
    raise(signal);
    sigprocmask(SIG_UNBLOCK, &one, nullptr);
    return 128 + signal;  // The first process of a container does not die of its own signals.
  }

  const SupervisorOptions options_;
  RenderingTable& table_;
  const std::function<int(const Supervised&)>& work_;
  Descriptor signals_, log_, orders_;
  pid_t child_ = -1;
  std::string boot_id_;
  LogTail tail_;
  std::vector<WorkerExit> exits_;
  int orders_given_ = 0;
  absl::Duration delay_;
};

}  // namespace

SupervisorOrder NextOrder(int orders) {
  char order = 0;
  ssize_t count = 0;
  while ((count = read(orders, &order, 1)) < 0 && errno == EINTR) {
  }
  return count == 1 && order == kDrain ? SupervisorOrder::kDrain : SupervisorOrder::kLeave;
}

int Supervise(const SupervisorOptions& options, RenderingTable& table,
              const std::function<int(const Supervised&)>& work) {
  return Supervisor(options, table, work).Run();
}

}  // namespace shutterline::worker
