// The coordinator is killed at random instants, by SIGKILL, while jobs and tiles are being acknowledged.
//
//     SHUTTERLINE_KILLS=500 durability_test --gtest_filter='CoordinatorKill*'
//
// kills it so often (20 times unless told).
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>

#include "tests/integration/farm.h"
#include "tests/integration/recording_client.h"
#include "tests/server/fake_worker.h"

namespace shutterline {
namespace {

int Kills() {
  const char* text = std::getenv("SHUTTERLINE_KILLS");
  int kills = 0;
  return text != nullptr && absl::SimpleAtoi(text, &kills) ? kills : 20;
}

class CoordinatorKillTest : public testing::Test {
 protected:
  v1::Job Get(const std::string& id) {
    grpc::ClientContext context;
    context.set_wait_for_ready(true);
    v1::JobRef ref;
    ref.set_job_id(id);
    v1::Job job;
    const grpc::Status status = farm_.Stub()->Get(&context, ref, &job);
    EXPECT_TRUE(status.ok()) << "job " << id << ": " << status.error_message();
    return job;
  }

  void KillAndRestart() {
    farm_.server().Signal(SIGKILL);
    ASSERT_EQ(farm_.server().Wait(), 128 + SIGKILL);
    farm_.StartServer();
  }

  /// Jobs and tiles that were acknowledged before now are there.
  void ExpectAllThere(const RecordingClient& client, const std::set<std::string>& jobs,
                      const std::set<RecordingClient::Tile>& tiles) {
    const auto stub = farm_.Stub();
    for (const std::string& id : jobs) {
      grpc::ClientContext context;
      context.set_wait_for_ready(true);
      v1::JobRef ref;
      ref.set_job_id(id);
      v1::Job job;
      const grpc::Status status = stub->Get(&context, ref, &job);
      ASSERT_TRUE(status.ok()) << "acknowledged job " << id << " is lost: " << status.error_message();
    }
    const auto unknown = client.Unknown(tiles);
    EXPECT_EQ(unknown.size(), 0u) << "of " << tiles.size() << " acknowledged tiles";
  }

  Farm farm_;
};

TEST_F(CoordinatorKillTest, ACoordinatorCrashLosesNeitherTheQueueNorCompletionReports) {
  farm_.StartServer();
  ASSERT_FALSE(HasFatalFailure());
  // 6 tiles a frame, the borders cut.
  const std::string first =
      farm_.Submit({farm_.Scene("plane"), "--size", "90x50", "--float", "--frames", "3-4"});
  const v1::JobSpec spec = Get(first).spec();
  const uint32_t seed = std::random_device()();
  std::printf("seed %u\n", seed);
  std::mt19937 random(seed);
  // Enough for all kills to meet work, few enough to be finished afterwards.
  RecordingClient client(farm_.Address(), spec, size_t(5 * Kills()));
  std::set<std::string> checked_jobs;
  std::set<RecordingClient::Tile> checked_tiles;
  for (int kill = 0; kill < Kills() && !HasFailure(); ++kill) {
    absl::SleepFor(absl::Milliseconds(random() % 250));
    KillAndRestart();
    ASSERT_FALSE(HasFatalFailure());
    // Those that were not looked for before; all of them at the end.
    std::set<std::string> jobs = client.AcknowledgedJobs();
    std::set<RecordingClient::Tile> tiles = client.AcknowledgedTiles();
    std::erase_if(jobs, [&](const auto& job) { return !checked_jobs.insert(job).second; });
    std::erase_if(tiles, [&](const auto& tile) { return !checked_tiles.insert(tile).second; });
    ExpectAllThere(client, jobs, tiles);
  }
  client.StopSubmitting();
  const std::set<std::string> jobs = client.AcknowledgedJobs();
  // What was submitted comes to its end, with the pixels that were acknowledged.
  std::string last;
  for (const std::string& id : jobs) {
    const v1::Job ended =
        farm_.WatchUntil(id, [](const v1::Job& j) { return j.state() == v1::JOB_STATE_SUCCEEDED; });
    ASSERT_EQ(ended.tiles_done(), ended.tiles_total());
    ASSERT_EQ(ended.mismatched_tiles(), 0u);
    last = id;
  }
  ExpectAllThere(client, jobs, client.AcknowledgedTiles());
  std::printf("jobs acknowledged: %zu, tiles acknowledged: %zu\n", jobs.size(),
              client.AcknowledgedTiles().size());
  EXPECT_GT(client.AcknowledgedTiles().size(), 0u);
  ASSERT_FALSE(last.empty());
  const std::string file = (farm_.folder() / "last.####.exr").string();
  farm_.Fetch(last, file);
  for (const int frame : {3, 4}) {
    const std::vector<uint32_t> bits = PixelBits(farm_.folder() / absl::StrCat("last.000", frame, ".exr"));
    ASSERT_EQ(bits.size(), 90u * 50 * 4);
    for (int y = 0; y < 50; ++y) {
      for (int x = 0; x < 90; ++x) {
        float expected[4];
        test::SyntheticPixel(frame, x, y, expected);
        ASSERT_EQ(std::memcmp(&bits[size_t(y * 90 + x) * 4], expected, sizeof expected), 0) << x << ", " << y;
      }
    }
  }
  // Its streams end with the coordinator.
  farm_.server().Signal(SIGKILL);
  client.Stop();
}

}  // namespace
}  // namespace shutterline
