// A file system of a few megabytes fills up while the coordinator is at work on it. Needs the right to mount
// one; where it is refused the test is skipped. The same with injected errors, at every operation:
// crash_points_test.
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "tests/integration/farm.h"

namespace shutterline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A small file system that only this process, and those that it starts, can see.
class SmallDisk {
 public:
  explicit SmallDisk(fs::path folder) : folder_(std::move(folder)) {
    fs::create_directories(folder_);
    mounted_ = ::unshare(CLONE_NEWNS) == 0 &&
               ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
               ::mount("tmpfs", folder_.c_str(), "tmpfs", 0, "size=8m") == 0;
    if (!mounted_) why_ = std::strerror(errno);
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(folder_.c_str(), MNT_DETACH);
  }
  bool mounted() const { return mounted_; }
  const std::string& why() const { return why_; }

  /// Takes all the space that there is.
  void Fill() {
    const int file = ::open((folder_ / "ballast").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
    ASSERT_GE(file, 0);
    const std::string page(4096, 'x');
    while (::write(file, page.data(), page.size()) > 0) {
    }
    EXPECT_EQ(errno, ENOSPC);
    ::close(file);
  }
  void Empty() { fs::remove(folder_ / "ballast"); }

 private:
  const fs::path folder_;
  bool mounted_ = false;
  std::string why_;
};

std::vector<std::string> Submission(const std::string& scene) {
  return {scene, "--size", "150x100", "--float", "--frame", "3"};
}

TEST(DiskFullTest, ACoordinatorWhoseDiskIsFullLosesNothingAndGoesOnWhenThereIsSpace) {
  Farm farm;
  SmallDisk disk(farm.folder() / "small");
  if (!disk.mounted()) GTEST_SKIP() << "SKIPPED: a file system cannot be mounted here: " << disk.why();
  farm.SetDataFolder(farm.folder() / "small" / "data");
  const std::string debris = farm.Scene("debris"), plane = farm.Scene("plane");
  const std::string truth = (farm.folder() / "truth.exr").string();
  std::vector<std::string> render = Submission(debris);
  render.insert(render.begin(), "render");
  render.insert(render.end(), {"-o", truth});
  ASSERT_EQ(farm.Client(render).status, 0);

  farm.StartServer();
  ASSERT_FALSE(testing::Test::HasFatalFailure());
  const std::string job = farm.Submit(Submission(debris));
  disk.Fill();
  // What a client sends is refused, with the reason.
  std::vector<std::string> submit = Submission(plane);
  submit.insert(submit.begin(), "submit");
  submit.insert(submit.end(), {"--server", farm.Address()});
  const Farm::Ended refused = farm.Client(submit);
  EXPECT_EQ(refused.status, 1) << refused.output;
  EXPECT_THAT(refused.errors, HasSubstr("No space left on device"));
  // What workers send is not acknowledged: they keep it.
  farm.StartWorker("one", 1);
  ASSERT_TRUE(WaitUntil(
      [&] { return farm.server().Errors().find("results could not be stored") != std::string::npos; }));
  EXPECT_TRUE(farm.server().Running());
  const v1::Job waiting = farm.WatchUntil(job, [](const v1::Job&) { return true; });
  EXPECT_EQ(waiting.tiles_done(), 0u);

  disk.Empty();
  const std::string file = (farm.folder() / "frame.exr").string();
  farm.Fetch(job, file);
  EXPECT_EQ(PixelBits(file), PixelBits(truth));
  EXPECT_EQ(farm.Client(submit).status, 0);
  EXPECT_TRUE(farm.server().Running()) << "the same process all the time";
}

}  // namespace
}  // namespace shutterline
