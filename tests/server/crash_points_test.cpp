// The coordinator's process ends, the power goes, or the disk fills up, at every single operation on files in
// turn: nothing that has been acknowledged is lost, and the job can be finished.
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <new>

#include "common/base/check.h"
#include "tests/server/crash_workload.h"
#include "tests/server/shadow_disk.h"
#include "tests/server/sqlite_faults.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::test {
namespace {

using server::Durability;
using server::FileFaults;
using server::FileOperation;
using server::InstallFileFaults;
using Kind = FileOperation::Kind;

constexpr int kDied = 42;

/// Acknowledgements that outlive the child that makes them.
class SharedAcknowledged {
 public:
  SharedAcknowledged() {
    void* const memory =
        ::mmap(nullptr, sizeof(Acknowledged), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    SL_CHECK(memory != MAP_FAILED);
    value_ = new (memory) Acknowledged();
  }
  ~SharedAcknowledged() { ::munmap(value_, sizeof(Acknowledged)); }
  Acknowledged& operator*() { return *value_; }
  Acknowledged* operator->() { return value_; }

 private:
  Acknowledged* value_;
};

/// Calls `at` before operation number `position`, from 0; with `torn`, a write is given half of its bytes
/// first, so that `at` comes between the halves.
class AtOperation final : public FileFaults {
 public:
  AtOperation(int position, bool torn, std::function<void()> at)
      : position_(position), torn_(torn), at_(std::move(at)) {}

  Verdict Before(const FileOperation& operation) override {
    const int now = next_++;
    if (shadow != nullptr) shadow->Before(operation);
    if (now == position_ && torn_ && operation.kind == Kind::kWrite && operation.bytes > 1) {
      return {0, operation.bytes / 2};
    }
    if (now == position_ + (torn_ ? 1 : 0)) at_();
    return {};
  }
  int count() const { return next_; }

  ShadowDisk* shadow = nullptr;

 private:
  const int position_;
  const bool torn_;
  const std::function<void()> at_;
  int next_ = 0;  // Operations follow one another: the workload waits for its one other thread.
};

/// The `count` operations from `position` on, removals excepted, fail with `error`.
class Failing final : public FileFaults {
 public:
  Failing(int position, int count, int error) : position_(position), count_(count), error_(error) {}

  Verdict Before(const FileOperation& operation) override {
    const int now = next_++;
    const bool fails = now >= position_ && now < position_ + count_ && operation.kind != Kind::kRemove;
    return {fails ? error_ : 0, SIZE_MAX};
  }

 private:
  const int position_, count_, error_;
  std::atomic<int> next_ = 0;
};

class CrashPointsTest : public testing::Test {
 protected:
  CrashPointsTest() {
    // Thousands of flushes: in memory, where they cost nothing. What they mean is ShadowDisk's affair.
    if (::access("/dev/shm", W_OK) == 0) ::setenv("TMPDIR", "/dev/shm", 0);
    LetFaultsSeeSqlite();
    spdlog::set_level(spdlog::level::off);
  }
  ~CrashPointsTest() override {
    InstallFileFaults(nullptr);
    spdlog::set_level(spdlog::level::info);
  }

  /// Operations that the whole workload takes, with or without the removal of its job.
  static int CountOperations(Durability durability, bool removes = false) {
    const TemporaryFolder folder;
    AtOperation counter(-2, false, [] {});
    InstallFileFaults(&counter);
    SharedAcknowledged acknowledged;
    {
      CrashWorkload workload(folder.path() + "/data", durability);
      EXPECT_TRUE(workload.Open().ok());
      const absl::Status status = workload.Run(*acknowledged);
      EXPECT_TRUE(status.ok()) << status;
      if (removes) {
        const absl::Status removed = workload.Remove(*acknowledged);
        EXPECT_TRUE(removed.ok()) << removed;
      }
    }
    InstallFileFaults(nullptr);
    return counter.count();
  }

  /// Runs the workload in a child that calls `at` at the operation, which ends it. False: it came to its end.
  static bool DieAt(const std::string& data, Durability durability, int position, bool torn,
                    SharedAcknowledged& acknowledged, const std::string& power_cut_to = "",
                    bool removes = false) {
    const pid_t child = ::fork();
    SL_CHECK(child >= 0);
    if (child == 0) {
      // Whatever happens, a child never goes on with the tests.
      std::set_terminate([] { ::_exit(3); });
      ShadowDisk shadow(data);
      AtOperation faults(position, torn, [&] {
        if (!power_cut_to.empty()) shadow.Restore(power_cut_to);
        ::_exit(kDied);
      });
      if (!power_cut_to.empty()) faults.shadow = &shadow;
      InstallFileFaults(&faults);
      [&]() noexcept {
        CrashWorkload workload(data, durability);
        const bool done = workload.Open().ok() && workload.Run(*acknowledged).ok() &&
                          (!removes || workload.Remove(*acknowledged).ok());
        ::_exit(done ? 0 : 1);
      }();
    }
    int status = 0;
    SL_CHECK(::waitpid(child, &status, 0) == child);
    EXPECT_TRUE(WIFEXITED(status) && (WEXITSTATUS(status) == kDied || WEXITSTATUS(status) == 0)) << status;
    return WIFEXITED(status) && WEXITSTATUS(status) == kDied;
  }

  /// Takes the folder up again: all is there, and the rest can be done.
  static void ExpectRecovers(const std::string& data, Durability durability,
                             SharedAcknowledged& acknowledged) {
    CrashWorkload workload(data, durability);
    const absl::Status opened = workload.Open();
    ASSERT_TRUE(opened.ok()) << opened;
    ASSERT_EQ(workload.Missing(*acknowledged), "");
    const absl::Status finished = workload.Run(*acknowledged);
    ASSERT_TRUE(finished.ok()) << finished;
    ASSERT_EQ(workload.Missing(*acknowledged), "");
  }
};

/// Takes the folder of a job up that may have been half removed: it is there as it was, or it and all of it
/// is gone.
void ExpectWholeOrGone(const std::string& data, Durability durability, SharedAcknowledged& acknowledged) {
  CrashWorkload workload(data, durability);
  const absl::Status opened = workload.Open();
  ASSERT_TRUE(opened.ok()) << opened;
  workload.WaitForFrames();
  ASSERT_EQ(workload.LeftOver(), "");
  const auto jobs = workload.farm().List(UINT64_MAX, 2);
  ASSERT_TRUE(jobs.ok()) << jobs.status();
  if (!jobs->empty()) {
    ASSERT_FALSE(acknowledged->removed);
    ASSERT_EQ(workload.Missing(*acknowledged), "");
  }
  const absl::Status removed = workload.Remove(*acknowledged);
  ASSERT_TRUE(removed.ok()) << removed;
  ASSERT_EQ(workload.LeftOver(), "");
  ASSERT_TRUE(workload.farm().List(UINT64_MAX, 2)->empty());
}

TEST_F(CrashPointsTest, ARemovalThatEndsAtAnyOperationLeavesAllOrNothing) {
  for (const Durability durability : {Durability::kProcess, Durability::kPower}) {
    const int first = CountOperations(durability), operations = CountOperations(durability, true);
    ASSERT_GT(operations - first, 10);
    for (int position = first; position < operations; ++position) {
      SCOPED_TRACE(testing::Message()
                   << "operation " << position << " of " << operations << ", durability " << int(durability));
      const TemporaryFolder folder;
      SharedAcknowledged acknowledged;
      const std::string data = folder.path() + "/data", left = folder.path() + "/left";
      const bool cut = durability == Durability::kPower;  // The power goes, or the process alone.
      if (!DieAt(data, durability, position, false, acknowledged, cut ? left : "", true)) continue;
      ExpectWholeOrGone(cut ? left : data, durability, acknowledged);
      if (HasFailure()) return;
    }
  }
}

TEST_F(CrashPointsTest, ARemovalWaitsForADiskThatIsFull) {
  const int first = CountOperations(Durability::kPower),
            operations = CountOperations(Durability::kPower, true);
  for (int position = first; position < operations; ++position) {
    SCOPED_TRACE(testing::Message() << "full from operation " << position << " of " << operations);
    const TemporaryFolder folder;
    SharedAcknowledged acknowledged;
    CrashWorkload workload(folder.path() + "/data", Durability::kPower);
    Failing faults(position, 3, ENOSPC);
    InstallFileFaults(&faults);
    ASSERT_TRUE(workload.Open().ok());
    ASSERT_TRUE(workload.Run(*acknowledged).ok());
    absl::Status status = workload.Remove(*acknowledged);
    for (int tries = 0; !status.ok() && tries < 20; ++tries) status = workload.Remove(*acknowledged);
    ASSERT_TRUE(status.ok()) << status;
    workload
        .WaitForFrames();  // Files go when there is room for the note that they are gone: some tries later.
    InstallFileFaults(nullptr);
    ASSERT_EQ(workload.LeftOver(), "");
    if (HasFailure()) return;
  }
}

TEST_F(CrashPointsTest, AProcessThatEndsAtAnyOperationLosesNothingAcknowledged) {
  for (const Durability durability : {Durability::kProcess, Durability::kPower}) {
    const int operations = CountOperations(durability);
    ASSERT_GT(operations, 50);
    for (int position = 0; position < operations; ++position) {
      for (const bool torn : {false, true}) {
        SCOPED_TRACE(testing::Message() << "operation " << position << " of " << operations
                                        << (torn ? ", torn" : "") << ", durability " << int(durability));
        const TemporaryFolder folder;
        SharedAcknowledged acknowledged;
        DieAt(folder.path() + "/data", durability, position, torn, acknowledged);
        ExpectRecovers(folder.path() + "/data", durability, acknowledged);
        if (HasFailure()) return;
      }
    }
  }
}

TEST_F(CrashPointsTest, APowerCutAtAnyOperationLosesNothingAcknowledged) {
  const int operations = CountOperations(Durability::kPower);
  for (int position = 0; position < operations; ++position) {
    SCOPED_TRACE(testing::Message() << "operation " << position << " of " << operations);
    const TemporaryFolder folder;
    SharedAcknowledged acknowledged;
    const std::string left = folder.path() + "/left";
    if (!DieAt(folder.path() + "/data", Durability::kPower, position, false, acknowledged, left)) continue;
    ExpectRecovers(left, Durability::kPower, acknowledged);
    if (HasFailure()) return;
  }
}

/// Also shows that the test above can fail: without flushes a cut of power does lose what was acknowledged.
TEST_F(CrashPointsTest, WithoutFlushesAPowerCutLosesTiles) {
  const int operations = CountOperations(Durability::kProcess);
  int lost = 0;
  for (int position = 0; position < operations; position += 5) {
    const TemporaryFolder folder;
    SharedAcknowledged acknowledged;
    const std::string left = folder.path() + "/left";
    if (!DieAt(folder.path() + "/data", Durability::kProcess, position, false, acknowledged, left)) continue;
    CrashWorkload workload(left, Durability::kProcess);
    if (!workload.Open().ok() || !workload.Missing(*acknowledged).empty()) ++lost;
  }
  EXPECT_GT(lost, 0);
}

/// The disk has no room for a while, from any operation on: calls say so, and once there is room again the
/// same coordinator, without a restart, does all that is left.
TEST_F(CrashPointsTest, ADiskThatIsFullFromAnyOperationOnLosesNothingAndWorkGoesOn) {
  const int operations = CountOperations(Durability::kPower);
  for (int position = 0; position < operations; ++position) {
    for (const int length : {1, 9}) {
      SCOPED_TRACE(testing::Message()
                   << "full from operation " << position << " of " << operations << " for " << length);
      const TemporaryFolder folder;
      SharedAcknowledged acknowledged;
      Failing faults(position, length, ENOSPC);
      InstallFileFaults(&faults);
      auto workload = std::make_unique<CrashWorkload>(folder.path() + "/data", Durability::kPower);
      absl::Status opened = workload->Open();
      for (int tries = 0; !opened.ok() && tries < 20; ++tries) {
        // A coordinator that cannot start is started again.
        workload = std::make_unique<CrashWorkload>(folder.path() + "/data", Durability::kPower);
        opened = workload->Open();
      }
      ASSERT_TRUE(opened.ok()) << opened;
      absl::Status status = workload->Run(*acknowledged);
      for (int tries = 0; !status.ok() && tries < 20; ++tries) {
        ASSERT_EQ(workload->Missing(*acknowledged), "") << status;
        status = workload->Run(*acknowledged);
      }
      ASSERT_TRUE(status.ok()) << status;
      ASSERT_EQ(workload->Missing(*acknowledged), "");
      workload.reset();
      InstallFileFaults(nullptr);
      ExpectRecovers(folder.path() + "/data", Durability::kPower, acknowledged);
      if (HasFailure()) return;
    }
  }
}

}  // namespace
}  // namespace shutterline::test
