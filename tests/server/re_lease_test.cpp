// How soon the tiles of a worker that is gone go to another, by a clock that a test holds.
#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "tests/server/crash_workload.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::test {
namespace {

using server::WorkerId;

/// The coordinator ticks that often.
constexpr absl::Duration kTick = absl::Milliseconds(50);

/// A worker that holds what it is granted, and does nothing with it.
class Holder final : public server::WorkerSink {
 public:
  Holder(server::Farm& farm, const std::string& uuid, int64_t credit) : farm_(farm) {
    server::WorkerHello hello;
    hello.uuid = hello.name = uuid;
    hello.boot_id = uuid + " boot";
    hello.build_id = "build";
    hello.isa = "fake";
    hello.protocol_low = hello.protocol_high = 1;
    hello.slots = 1;
    const auto entry = farm_.Register(hello);
    EXPECT_TRUE(entry.ok()) << entry.status();
    const auto id = farm_.Attach(entry->session_id, farm_.epoch(), {}, this);
    EXPECT_TRUE(id.ok()) << id.status();
    id_ = *id;
    farm_.AddCredit(id_, credit);
  }
  ~Holder() override { farm_.Detach(id_, this, true); }

  void Send(server::WorkerEvent event) override {
    if (const auto* grant = std::get_if<server::LeaseGranted>(&event)) {
      leases.push_back(grant->lease);
      for (const uint32_t tile : grant->tiles) tiles.emplace(grant->frame, tile);
    }
  }
  void Close(const absl::Status&) override {}
  /// The connection breaks, as it does when the process dies.
  void Die() { farm_.Detach(id_, this, false); }
  void Heartbeat() { farm_.Heartbeat(id_, leases); }

  std::set<std::pair<int, uint32_t>> tiles;
  std::vector<server::LeaseId> leases;

 private:
  server::Farm& farm_;
  WorkerId id_ = 0;
};

class ReLeaseTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(workload_.Open().ok());
    Acknowledged acknowledged{};
    ASSERT_TRUE(workload_.Submit(acknowledged).ok());
  }

  /// Time passes, with heartbeats of `heir`, until it holds all tiles, at most a minute.
  absl::Duration TimeUntilAllAreHeldBy(Holder& heir) {
    const absl::Duration start = workload_.clock().Monotonic();
    while (heir.tiles.size() < 8 && workload_.clock().Monotonic() - start < absl::Minutes(1)) {
      workload_.clock().Advance(kTick);
      heir.Heartbeat();
      workload_.farm().Tick();
    }
    return workload_.clock().Monotonic() - start;
  }

  TemporaryFolder folder_;
  CrashWorkload workload_{folder_.path() + "/data", server::Durability::kProcess};
};

TEST_F(ReLeaseTest, TilesOfADeadProcessAreLeasedAgainWithinASecond) {
  Holder victim(workload_.farm(), "victim", 3), heir(workload_.farm(), "heir", 100);
  ASSERT_EQ(victim.tiles.size(), 3u);
  ASSERT_EQ(heir.tiles.size(), 5u);
  victim.Die();
  EXPECT_LE(TimeUntilAllAreHeldBy(heir), absl::Seconds(1));
  EXPECT_EQ(heir.tiles.size(), 8u);
}

TEST_F(ReLeaseTest, TilesOfASilentWorkerAreLeasedAgainAfterFifteenSeconds) {
  Holder silent(workload_.farm(), "silent", 3), heir(workload_.farm(), "heir", 100);
  ASSERT_EQ(heir.tiles.size(), 5u);
  const absl::Duration time = TimeUntilAllAreHeldBy(heir);
  EXPECT_EQ(heir.tiles.size(), 8u);
  EXPECT_LE(time, absl::Seconds(15));
  EXPECT_GT(time, absl::Seconds(14)) << "it may only have been busy";
}

}  // namespace
}  // namespace shutterline::test
