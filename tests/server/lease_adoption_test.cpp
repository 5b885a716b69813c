// Tiles in flight when a session or a coordinator ends, and tiles that keep everybody waiting.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>

#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::server {
namespace {

using test::FakeWorker;
using testing::ElementsAreArray;

class LeaseAdoptionTest : public test::CoordinatorFixture {
 protected:
  static v1::HeldLease Held(const v1::Grant& grant, uint64_t ticket) {
    v1::HeldLease held;
    held.set_ticket(ticket);
    held.set_job_id(grant.job_id());
    held.set_frame(grant.frame());
    *held.mutable_tiles() = grant.tiles();
    return held;
  }
};

TEST_F(LeaseAdoptionTest, TilesInFlightAtARestartAreNotRenderedTwice) {
  config_.adoption_time = absl::Minutes(10);  // Only the worker's return ends it.
  StopCoordinator();
  StartCoordinator();
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 128, 64));  // 8 tiles.
  auto a = std::make_unique<FakeWorker>(channel_, "a"), b = std::make_unique<FakeWorker>(channel_, "b");
  std::vector<v1::Grant> grants;
  a->Credit(3);
  for (int i = 0; i < 3; ++i) grants.push_back(a->NextGrant());
  {
    FakeWorker dying(channel_, "dying");
    dying.Credit(1);
    dying.NextGrant();
  }
  // One of these was the dead worker's: the tick that buries it also notes who is connected.
  b->Credit(5);
  for (int i = 0; i < 5; ++i) b->NextGrant();
  StopCoordinator();
  a.reset();
  b.reset();
  StartCoordinator();
  b = std::make_unique<FakeWorker>(channel_, "b");
  b->Credit(10);
  a = std::make_unique<FakeWorker>(
      channel_, "a",
      std::vector<v1::HeldLease>{Held(grants[0], 70), Held(grants[1], 71), Held(grants[2], 72)});
  std::set<uint32_t> of_a;
  for (int i = 0; i < 3; ++i) {
    const v1::Grant adopted = a->NextGrant();
    EXPECT_EQ(adopted.adopts(), uint64_t(70 + i));
    EXPECT_THAT(adopted.tiles(), ElementsAreArray(grants[size_t(i)].tiles()));
    of_a.insert(adopted.tiles().begin(), adopted.tiles().end());
    a->Render(adopted);
  }
  v1::CoordinatorMessage message;
  ASSERT_TRUE(a->Next(message));
  EXPECT_TRUE(message.has_adopted());
  std::set<uint32_t> of_b;
  while (of_b.size() < 8 - of_a.size()) {
    const v1::Grant grant = b->NextGrant();
    for (const uint32_t tile : grant.tiles()) EXPECT_FALSE(of_a.contains(tile)) << tile;
    of_b.insert(grant.tiles().begin(), grant.tiles().end());
    b->Render(grant);
  }
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
  ExpectSyntheticFrame(job.id(), 0, 128, 64);
}

TEST_F(LeaseAdoptionTest, FlappingHostDoesNotRenderItsTilesTwice) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 64, 32));
  v1::Grant grant;
  {
    FakeWorker worker(channel_, "flapping");
    worker.Credit(1);
    grant = worker.NextGrant();
  }
  // Whether or not the coordinator has noticed yet, the new session takes over what the old one held.
  FakeWorker worker(channel_, "flapping", {Held(grant, 5)});
  const v1::Grant adopted = worker.NextGrant();
  EXPECT_EQ(adopted.adopts(), 5u);
  EXPECT_THAT(adopted.tiles(), ElementsAreArray(grant.tiles()));
  FakeWorker other(channel_, "other");
  other.Credit(2);
  const v1::Grant rest = other.NextGrant();
  EXPECT_NE(rest.tiles(0), grant.tiles(0));
  other.Render(rest);
  worker.Render(adopted);
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
}

TEST_F(LeaseAdoptionTest, NonsenseThatAWorkerHoldsIsNotAdopted) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 64, 32));
  v1::Grant nonsense;
  nonsense.set_job_id(job.id());
  nonsense.set_frame(7);
  nonsense.add_tiles(0);
  v1::Grant unknown = nonsense, tile = nonsense;
  unknown.set_job_id("no such job");
  tile.set_frame(0);
  tile.set_tiles(0, 4'000'000'000u);
  FakeWorker worker(channel_, "fake", {Held(nonsense, 1), Held(unknown, 2), Held(tile, 3)});
  v1::CoordinatorMessage message;
  ASSERT_TRUE(worker.Next(message));
  EXPECT_TRUE(message.has_adopted());
  FakeWorker zero(channel_, "zero", {Held(nonsense, 0)});
  EXPECT_EQ(zero.SessionStatus().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(LeaseAdoptionTest, TileThatKeepsEverybodyWaitingIsRenderedByAnotherAndTheLoserIsTold) {
  config_.speculate_after = absl::Milliseconds(1);
  StopCoordinator();
  StartCoordinator();
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 96, 64));  // 6 tiles.
  FakeWorker slow(channel_, "slow"), fast(channel_, "fast");
  slow.Credit(1);
  const v1::Grant stuck = slow.NextGrant();
  fast.Credit(100);
  std::set<uint32_t> rendered;
  while (rendered.size() < 6) {
    const v1::Grant grant = fast.NextGrant();
    for (const uint32_t tile : grant.tiles()) EXPECT_TRUE(rendered.insert(tile).second) << tile;
    fast.Render(grant);
  }
  EXPECT_TRUE(rendered.contains(stuck.tiles(0)));
  v1::CoordinatorMessage message;
  ASSERT_TRUE(slow.Next(message));
  EXPECT_THAT(message.revoke().lease_ids(), testing::ElementsAre(stuck.lease_id()));
  EXPECT_THAT(slow.Render(stuck).outcomes(), testing::Each(testing::AnyOf(v1::ResultAck::OUTCOME_DUPLICATE,
                                                                          v1::ResultAck::OUTCOME_UNWANTED)));
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
  ExpectSyntheticFrame(job.id(), 0, 96, 64);
}

TEST_F(LeaseAdoptionTest, ALeaseHearsOfTilesThatOthersHaveDeliveredAndKeepsTheRest) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 320, 320));
  FakeWorker slow(channel_, "slow"), fast(channel_, "fast");
  slow.Credit(1);
  slow.Render(slow.NextGrant());  // Tiles are quick: leases are long from here on.
  slow.Credit(1);
  const v1::Grant grant = slow.NextGrant();
  ASSERT_GE(grant.tiles_size(), 4);
  const auto by_another = [&](std::vector<int> places) {
    std::vector<v1::TileResult> results;
    for (const int place : places) results.push_back(slow.Result(grant, grant.tiles(place)));
    EXPECT_THAT(fast.Push(results).outcomes(), testing::Each(v1::ResultAck::OUTCOME_STORED));
  };
  const auto told = [&] {
    v1::CoordinatorMessage message;
    EXPECT_TRUE(slow.Next(message));
    EXPECT_THAT(message.revoke().lease_ids(), testing::IsEmpty()) << "what an older worker reads: nothing";
    EXPECT_EQ(message.revoke().tiles_size(), 1);
    EXPECT_EQ(message.revoke().tiles(0).lease_id(), grant.lease_id());
    return std::vector<uint32_t>(message.revoke().tiles(0).tiles().begin(),
                                 message.revoke().tiles(0).tiles().end());
  };
  by_another({1});
  EXPECT_THAT(told(), testing::ElementsAre(grant.tiles(1)));
  by_another({3, 2});
  EXPECT_THAT(told(), testing::UnorderedElementsAre(grant.tiles(2), grant.tiles(3)));
  // The lease stands, and its worker's results count.
  EXPECT_EQ(slow.Push({slow.Result(grant, grant.tiles(0))}).outcomes(0), v1::ResultAck::OUTCOME_STORED);
  EXPECT_EQ(slow.Push({slow.Result(grant, grant.tiles(1))}).outcomes(0), v1::ResultAck::OUTCOME_DUPLICATE);
  slow.Render(grant);
  slow.RenderUntilForgotten();
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
  ExpectSyntheticFrame(job.id(), 0, 320, 320);
}

}  // namespace
}  // namespace shutterline::server
