#include "worker/supervise/supervisor.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstring>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/log.h"

namespace shutterline::worker {
namespace {

using testing::HasSubstr;

constexpr SupervisorOptions kQuick{.backoff_initial = absl::Milliseconds(1),
                                   .backoff_max = absl::Milliseconds(2)};

void Say(const char* text) {
  EXPECT_EQ(write(STDERR_FILENO, text, std::strlen(text)), ssize_t(std::strlen(text)));
}

/// A supervisor in a process of its own, whose standard error comes here. It is killed with this.
class Supervising {
 public:
  explicit Supervising(const std::function<int(const Supervised&)>& work,
                       const SupervisorOptions& options = kQuick) {
    int fds[2];
    EXPECT_EQ(pipe2(fds, O_CLOEXEC), 0);
    errors_ = fds[0];
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      const rlimit no_cores{0, 0};
      setrlimit(RLIMIT_CORE, &no_cores);
      dup2(fds[1], STDERR_FILENO);
      SetUpLog("test", "info").IgnoreError();
      _exit(Supervise(options, Table(), work));
    }
    close(fds[1]);
  }
  ~Supervising() {
    if (pid_ > 0) kill(pid_, SIGKILL), (void)Wait();
    close(errors_);
  }
  Supervising(const Supervising&) = delete;

  /// Shared by all: each test has its own process under `ctest`, and takes from it what it has put there.
  static RenderingTable& Table() {
    static RenderingTable& table = *RenderingTable::Create(2).value().release();
    return table;
  }

  /// Reads until the text has come, or the end.
  void ReadUntil(const std::string& text) {
    char byte;
    while (!absl::StrContains(said_, text) && read(errors_, &byte, 1) == 1) said_ += byte;
    EXPECT_THAT(said_, HasSubstr(text));
  }
  /// To the end: until nobody is left who could write.
  const std::string& ReadAll() {
    char bytes[4096];
    for (ssize_t count = 0; (count = read(errors_, bytes, sizeof bytes)) > 0;)
      said_.append(bytes, size_t(count));
    return said_;
  }
  void Signal(int signal) const { kill(pid_, signal); }
  /// As waitpid says it.
  int Wait() {
    int status = -1;
    waitpid(std::exchange(pid_, -1), &status, 0);
    return status;
  }

 private:
  pid_t pid_ = -1;
  int errors_ = -1;
  std::string said_;
};

int ExitOf(int status) {
  EXPECT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  return WEXITSTATUS(status);
}

TEST(Supervisor, PassesOnTheStatusOfAWorkerThatEnds) {
  Supervising one([](const Supervised& s) { return s.exits.empty() && !s.boot_id.empty() ? 0 : 9; });
  EXPECT_EQ(ExitOf(one.Wait()), 0);
  Supervising other([](const Supervised&) { return 3; });
  EXPECT_EQ(ExitOf(other.Wait()), 3);
  EXPECT_EQ(other.ReadAll(), "");
}

TEST(Supervisor, StartsAWorkerThatASignalEndsAgainAndTellsItHow) {
  Supervising supervising([](const Supervised& s) {
    if (s.exits.empty()) {
      Say("first line\nlast wo");
      Say("rds\xff\x1b[0m\nand a cut one");
      Supervising::Table().Begin(0, "job", 3, 7);
      Supervising::Table().Begin(1, "job", 3, 8);
      Supervising::Table().End(1);
      raise(SIGKILL);
    }
    const WorkerExit& exit = s.exits[0];
    const bool told = s.exits.size() == 1 && exit.signal == SIGKILL && exit.boot_id != s.boot_id &&
                      exit.log_tail == "first line\nlast words??[0m\nand a cut one\n" &&
                      exit.tiles == std::vector<TileAtHand>{{"job", 3, 7}};
    return told ? 42 : 1;
  });
  EXPECT_EQ(ExitOf(supervising.Wait()), 42);
  EXPECT_THAT(supervising.ReadAll(), HasSubstr("last words\xff\x1b[0m\nand a cut one"))
      << "the log as it was written";
}

TEST(Supervisor, ToldExitsAreTheLatestFour) {
  auto* const deaths = static_cast<std::atomic<int>*>(
      mmap(nullptr, sizeof(std::atomic<int>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  Supervising supervising([&](const Supervised& s) {
    if (deaths->load() == 6) {
      std::set<std::string> boots = {s.boot_id};
      for (const WorkerExit& exit : s.exits) boots.insert(exit.boot_id);
      return s.exits.size() == 4 && boots.size() == 5 && s.exits[3].signal == SIGSEGV ? 0 : 1;
    }
    ++*deaths;
    raise(deaths->load() == 6 ? SIGSEGV : SIGKILL);
    return 2;
  });
  EXPECT_EQ(ExitOf(supervising.Wait()), 0);
  munmap(deaths, sizeof(std::atomic<int>));
}

TEST(Supervisor, FirstSignalIsAnOrderToDrainAndTheSecondOneToLeave) {
  Supervising supervising([](const Supervised& s) {
    Say("ready\n");
    if (NextOrder(s.orders) != SupervisorOrder::kDrain) return 1;
    Say("drains\n");
    if (NextOrder(s.orders) != SupervisorOrder::kLeave) return 1;
    return 7;
  });
  supervising.ReadUntil("ready");
  supervising.Signal(SIGTERM);
  supervising.ReadUntil("drains");
  supervising.Signal(SIGINT);
  EXPECT_EQ(ExitOf(supervising.Wait()), 7);
}

TEST(Supervisor, WorkerFindsSignalsOfItsGroupBlocked) {
  Supervising supervising([](const Supervised& s) {
    raise(SIGTERM);
    raise(SIGINT);
    Say("ready\n");
    return NextOrder(s.orders) == SupervisorOrder::kDrain ? 5 : 1;
  });
  supervising.ReadUntil("ready");
  supervising.Signal(SIGTERM);
  EXPECT_EQ(ExitOf(supervising.Wait()), 5);
}

TEST(Supervisor, WorkerThatDiesAfterAnOrderIsNotStartedAgain) {
  Supervising supervising([](const Supervised& s) {
    Say(s.exits.empty() ? "ready\n" : "again\n");
    NextOrder(s.orders);
    raise(SIGABRT);
    return 1;
  });
  supervising.ReadUntil("ready");
  supervising.Signal(SIGTERM);
  const int status = supervising.Wait();
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT) << status;
  EXPECT_THAT(supervising.ReadAll(), testing::Not(HasSubstr("again")));
}

TEST(Supervisor, SignalBetweenTwoProcessesEndsIt) {
  Supervising supervising(
      [](const Supervised&) {
        raise(SIGKILL);
        return 1;
      },
      {.backoff_initial = absl::Hours(1), .backoff_max = absl::Hours(1)});
  supervising.ReadUntil("is started again");
  supervising.Signal(SIGTERM);
  EXPECT_EQ(ExitOf(supervising.Wait()), 0);
}

TEST(Supervisor, WorkerDiesWithItsSupervisor) {
  int alive[2];
  ASSERT_EQ(pipe(alive), 0);  // Open in both of them: it ends when both are gone.
  Supervising supervising([](const Supervised&) {
    Say("ready\n");
    while (true) pause();
    return 1;
  });
  close(alive[1]);
  supervising.ReadUntil("ready");
  supervising.Signal(SIGKILL);
  supervising.Wait();
  char byte;
  EXPECT_EQ(read(alive[0], &byte, 1), 0);
  close(alive[0]);
}

}  // namespace
}  // namespace shutterline::worker
