#include "tests/support/process.h"

#include <absl/time/clock.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <sstream>
#include <utility>

namespace shutterline {

std::unique_ptr<Process> Process::Start(const std::vector<std::string>& arguments,
                                        const std::filesystem::path& log) {
  // Everything that allocates is done before the fork.
  const std::string out = log.string() + ".out", err = log.string() + ".err";
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t pid = fork();
  if (pid < 0) return nullptr;
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int out_file = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    const int err_file = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    const int nothing = open("/dev/null", O_RDONLY);
    if (out_file < 0 || err_file < 0 || nothing < 0) _exit(127);
    dup2(nothing, 0);
    dup2(out_file, 1);
    dup2(err_file, 2);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    execv(argv[0], argv.data());
    _exit(127);
  }
  return std::unique_ptr<Process>(new Process(pid, log));
}

Process::Process(int pid, std::filesystem::path log) : pid_(pid), log_(std::move(log)) {
  reaper_ = std::thread([this] {
    // The process stays a zombie, and its number its own, until `status_` is about to be set.
    siginfo_t info;
    while (waitid(P_PID, id_t(pid_), &info, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
    }
    absl::MutexLock lock(&mutex_);
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    status_ = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  });
}

Process::~Process() {
  Signal(SIGKILL);
  reaper_.join();
}

void Process::Signal(int signal) const {
  absl::MutexLock lock(&mutex_);
  if (!status_) kill(pid_, signal);
}

std::optional<int> Process::Wait(absl::Duration timeout) {
  absl::MutexLock lock(&mutex_);
  const auto ended = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return status_.has_value(); };
  mutex_.AwaitWithTimeout(absl::Condition(&ended), timeout);
  return status_;
}

bool Process::Running() const {
  absl::MutexLock lock(&mutex_);
  return !status_;
}

std::string Process::Output() const {
  return ReadWholeFile(log_.string() + ".out");
}

std::string Process::Errors() const {
  return ReadWholeFile(log_.string() + ".err");
}

bool WaitUntil(const std::function<bool()>& done, absl::Duration timeout) {
  const absl::Time deadline = absl::Now() + timeout;
  while (!done()) {
    if (absl::Now() >= deadline) return false;
    poll(nullptr, 0, 5);
  }
  return true;
}

std::string ReadWholeFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace shutterline
