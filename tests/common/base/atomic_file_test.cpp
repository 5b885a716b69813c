#include "common/base/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

namespace shutterline {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("shutterline-atomic-" + std::to_string(getpid()) + "-" +
                                           testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override {
    fs::permissions(folder_, fs::perms::owner_all);
    fs::remove_all(folder_);
  }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Contents(const std::string& name) const {
    std::ifstream file(Path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  int FileCount() const { return int(std::distance(fs::directory_iterator(folder_), {})); }

  fs::path folder_;
};

TEST_F(AtomicFile, WritesAndReplaces) {
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "one").ok());
  ASSERT_TRUE(WriteFileAtomically(Path("a"), std::string("t\0o", 3)).ok());
  EXPECT_EQ(Contents("a"), std::string("t\0o", 3));
  ASSERT_TRUE(WriteFileAtomically(Path("empty"), "").ok());
  EXPECT_EQ(Contents("empty"), "");
  EXPECT_EQ(FileCount(), 2);
}

TEST_F(AtomicFile, MissingFolder) {
  const absl::Status status = WriteFileAtomically(Path("none/a"), "x");
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("none/a"));
  EXPECT_EQ(FileCount(), 0);
}

TEST_F(AtomicFile, TargetIsAFolder) {
  fs::create_directory(Path("a"));
  EXPECT_FALSE(WriteFileAtomically(Path("a"), "x").ok());
  EXPECT_EQ(FileCount(), 1);
}

/// In a child of its own, because what it gives up (root's rights) does not come back.
TEST_F(AtomicFile, ReadOnlyFolder) {
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "old").ok());
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read |
                               fs::perms::others_exec);
  const pid_t child = fork();
  if (child == 0) {
    if (getuid() == 0 && setuid(65534) != 0) _exit(3);
    const absl::Status status = WriteFileAtomically(Path("a"), "new");
    _exit(status.code() == absl::StatusCode::kPermissionDenied ? 0 : 1);
  }
  int result = 0;
  ASSERT_EQ(waitpid(child, &result, 0), child);
  EXPECT_TRUE(WIFEXITED(result) && WEXITSTATUS(result) == 0) << result;
  EXPECT_EQ(Contents("a"), "old");
  EXPECT_EQ(FileCount(), 1);
}

/// A write that fails half-way (here at a limit on file sizes, as at a full disk) leaves the old file.
TEST_F(AtomicFile, FailureHalfWayLeavesTheOldFile) {
  ASSERT_TRUE(WriteFileAtomically(Path("a"), "old").ok());
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(3);
    _exit(WriteFileAtomically(Path("a"), std::string(5000, 'n')).ok() ? 1 : 0);
  }
  int result = 0;
  ASSERT_EQ(waitpid(child, &result, 0), child);
  EXPECT_TRUE(WIFEXITED(result) && WEXITSTATUS(result) == 0) << result;
  EXPECT_EQ(Contents("a"), "old");
  EXPECT_EQ(FileCount(), 1);
}

TEST_F(AtomicFile, ConcurrentWritersLeaveOneWholeFile) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([this, i] {
      for (int k = 0; k < 5; ++k) {
        EXPECT_TRUE(WriteFileAtomically(Path("a"), std::string(10000, char('a' + i))).ok());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const std::string contents = Contents("a");
  EXPECT_EQ(contents, std::string(10000, contents[0]));
  EXPECT_EQ(FileCount(), 1);
}

}  // namespace
}  // namespace shutterline
