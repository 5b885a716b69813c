#include "worker/loop/lease_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <thread>

namespace shutterline::worker {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::shared_ptr<const WorkerJob> Job() {
  return std::make_shared<WorkerJob>();
}

/// Of a frame that is ready.
TileTask Take(LeaseBoard& board) {
  TileTask task = board.Take().value();
  board.FrameReady(task, true);
  return task;
}

std::shared_ptr<const WorkerJob> JobOf(const char* scene) {
  auto job = std::make_shared<WorkerJob>();
  job->scene_key = Sha256(scene);
  return job;
}

TEST(LeaseBoard, ALeaseOccupiesCreditUntilRenderedAndLivesUntilAcknowledged) {
  LeaseBoard board;
  int progress = 0;
  board.OnProgress([&] { ++progress; });
  const uint32_t tiles[] = {5, 2};
  ASSERT_TRUE(board.Grant(Job(), 7, 3, tiles));
  EXPECT_FALSE(board.Grant(Job(), 7, 3, tiles)) << "held already";
  const TileTask first = Take(board), second = Take(board);
  EXPECT_EQ(first.tile, 5u);
  EXPECT_EQ(second.tile, 2u);
  EXPECT_EQ(second.frame, 3);
  board.Rendered(first);
  board.Acknowledged(first);
  EXPECT_EQ(progress, 0);
  EXPECT_EQ(board.UnrenderedLeases(), 1u);
  board.Rendered(second);
  EXPECT_EQ(progress, 1);
  EXPECT_EQ(board.UnrenderedLeases(), 0u);
  EXPECT_TRUE(board.Idle());
  EXPECT_THAT(board.LiveLeases(), ElementsAre(7u));
  board.Acknowledged(second);
  EXPECT_THAT(board.LiveLeases(), IsEmpty());
}

TEST(LeaseBoard, TheLastTileOfAFrameThatIsHeldIsKnownAsSuch) {
  LeaseBoard board;
  const auto job = Job();
  const uint32_t two[] = {0, 1}, one[] = {2};
  board.Grant(job, 1, 0, two);
  board.Grant(job, 2, 0, one);
  board.Grant(job, 3, 1, one);
  board.Grant(Job(), 4, 0, one);
  const TileTask a = Take(board), b = Take(board), c = Take(board), next = Take(board);
  EXPECT_FALSE(board.Rendered(a));
  EXPECT_FALSE(board.Rendered(c)) << "another thread is at a tile of it";
  EXPECT_TRUE(board.Rendered(b)) << "what is left is of another frame, or job";
  EXPECT_TRUE(board.Rendered(next));
  EXPECT_FALSE(b.send_at_once);
}

TEST(LeaseBoard, WhatIsRevokedIsNotWaitedFor) {
  LeaseBoard board;
  const auto job = Job();
  const uint32_t two[] = {0, 1}, three[] = {2, 3, 4};
  board.Grant(job, 1, 0, two);
  board.Grant(job, 2, 0, three, true);
  const TileTask a = Take(board);
  board.RevokeTiles(1, std::vector<uint32_t>{1});
  const uint64_t other = 2;
  const TileTask c = Take(board);
  EXPECT_TRUE(c.send_at_once);
  board.Revoke({&other, 1});
  EXPECT_TRUE(board.Rendered(a));
  EXPECT_TRUE(board.Rendered(c)) << "though its lease is over";
}

TEST(LeaseBoard, RevokedTilesAreNotHandedOut) {
  LeaseBoard board;
  const uint32_t three[] = {0, 1, 2}, one[] = {9};
  board.Grant(Job(), 1, 0, three);
  board.Grant(Job(), 2, 0, one);
  const TileTask under_way = Take(board);
  const uint64_t revoked[] = {1, 55};
  board.Revoke(revoked);
  EXPECT_EQ(board.UnrenderedLeases(), 1u);
  EXPECT_THAT(board.LiveLeases(), ElementsAre(2u));
  EXPECT_EQ(Take(board).tile, 9u);
  board.Rendered(under_way);
  board.Acknowledged(under_way);
  EXPECT_EQ(board.UnrenderedLeases(), 1u) << "the other lease's tile is still under way";
}

TEST(LeaseBoard, ALeaseGoesOnWithoutTilesThatAreRevoked) {
  LeaseBoard board;
  int progress = 0;
  const uint32_t five[] = {0, 1, 2, 3, 4}, one[] = {2};
  board.Grant(Job(), 1, 0, five);
  board.Grant(Job(), 2, 0, one);
  const TileTask rendered = Take(board), under_way = Take(board);
  board.Rendered(rendered);
  board.OnProgress([&] { ++progress; });
  const uint32_t revoked[] = {0, 1, 2, 4, 77};
  board.RevokeTiles(1, revoked);
  board.RevokeTiles(3, revoked);  // Not held.
  EXPECT_EQ(progress, 1);
  const TileTask last = Take(board);
  EXPECT_EQ(last.tile, 3u) << "of the lease that lost the others";
  EXPECT_EQ(Take(board).tile, 2u) << "of the other lease";
  board.Rendered(under_way);
  EXPECT_EQ(board.UnrenderedLeases(), 2u);
  board.Rendered(last);
  EXPECT_EQ(board.UnrenderedLeases(), 1u);
  // What was rendered before is waited for.
  board.Acknowledged(last);
  EXPECT_THAT(board.LiveLeases(), ElementsAre(1u, 2u));
  board.Acknowledged(rendered);
  EXPECT_THAT(board.LiveLeases(), ElementsAre(2u));
}

TEST(LeaseBoard, ALeaseAllOfWhoseTilesAreRevokedIsOver) {
  LeaseBoard board;
  const uint32_t two[] = {0, 1};
  board.Grant(Job(), 1, 0, two);
  const TileTask under_way = Take(board);
  board.RevokeTiles(1, two);
  EXPECT_EQ(board.UnrenderedLeases(), 0u);
  EXPECT_THAT(board.LiveLeases(), IsEmpty());
  EXPECT_FALSE(board.Idle());
  board.Rendered(under_way);
  EXPECT_TRUE(board.Idle());
  board.Acknowledged(under_way);
  EXPECT_TRUE(board.Grant(Job(), 1, 0, two));
}

TEST(LeaseBoard, TilesOfAnEarlierSessionDoNotCountForALeaseOfTheSameNumber) {
  LeaseBoard board;
  const uint32_t tiles[] = {0};
  board.Grant(Job(), 1, 0, tiles);
  const TileTask old = Take(board);
  board.Suspend();
  EXPECT_THAT(board.LiveLeases(), IsEmpty());
  board.DropSuspended();
  board.Grant(Job(), 1, 0, tiles);
  board.Rendered(old);
  board.Acknowledged(old);
  EXPECT_EQ(board.UnrenderedLeases(), 1u);
  EXPECT_THAT(board.LiveLeases(), ElementsAre(1u));
  EXPECT_FALSE(board.Idle());
}

TEST(LeaseBoard, AdoptedLeaseGoesOnUnderItsNewNumberAndTheRestIsDropped) {
  LeaseBoard board;
  const uint32_t four[] = {4, 5, 6, 7}, other[] = {9};
  board.Grant(Job(), 1, 3, four);
  board.Grant(Job(), 2, 3, other);
  const TileTask rendered = Take(board), taken = Take(board);
  board.Rendered(rendered);
  board.Suspend();
  const std::vector<LeaseBoard::Held> held = board.Suspended();
  ASSERT_EQ(held.size(), 2u);
  EXPECT_THAT(held[0].tiles, ElementsAre(4u, 5u, 6u, 7u));  // None is acknowledged.
  EXPECT_EQ(held[0].frame, 3);
  // Somebody else has got tile 6 meanwhile, and the other lease altogether.
  const uint32_t adopted[] = {4, 5, 7};
  EXPECT_TRUE(board.Adopt(held[0].ticket, 100, adopted));
  EXPECT_FALSE(board.Adopt(held[0].ticket, 101, adopted)) << "adopted already";
  EXPECT_FALSE(board.Adopt(999, 102, adopted)) << "unknown";
  board.DropSuspended();
  EXPECT_THAT(board.LiveLeases(), ElementsAre(100u));
  EXPECT_EQ(board.UnrenderedLeases(), 1u);
  EXPECT_EQ(Take(board).tile, 7u);
  board.Rendered(taken);
  TileTask last = taken;
  last.tile = 7;
  board.Rendered(last);
  EXPECT_TRUE(board.Idle());
  EXPECT_EQ(board.UnrenderedLeases(), 0u);
  for (const TileTask& task : {rendered, taken, last}) board.Acknowledged(task);
  EXPECT_THAT(board.LiveLeases(), IsEmpty());
}

TEST(LeaseBoard, CloseWakesWaitingThreads) {
  LeaseBoard board;
  std::thread waiting([&] { EXPECT_FALSE(board.Take().has_value()); });
  board.Close();
  waiting.join();
}

TEST(LeaseBoard, AnyOrderOfEventsEndsWithNothingHeld) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    LeaseBoard board;
    std::vector<TileTask> taken, rendered;
    uint64_t next = 1;
    const auto pop = [&](std::vector<TileTask>& from) {
      std::swap(from[random() % from.size()], from.back());
      TileTask task = from.back();
      from.pop_back();
      return task;
    };
    size_t waiting = 0;
    for (int step = 0; step < 300; ++step) {
      switch (random() % 5) {
        case 0: {
          const std::vector<uint32_t> tiles(1 + random() % 4, uint32_t(step));
          ASSERT_TRUE(board.Grant(Job(), next++, 0, tiles));
          waiting += tiles.size();
          break;
        }
        case 1:
        case 2:
          if (waiting > 0) {
            taken.push_back(Take(board));
            --waiting;
          }
          break;
        case 3:
          if (!taken.empty()) {
            rendered.push_back(pop(taken));
            board.Rendered(rendered.back());
          }
          break;
        case 4:
          if (!rendered.empty()) board.Acknowledged(pop(rendered));
          break;
      }
    }
    for (; waiting > 0; --waiting) taken.push_back(Take(board));
    while (!taken.empty()) {
      rendered.push_back(pop(taken));
      board.Rendered(rendered.back());
    }
    EXPECT_EQ(board.UnrenderedLeases(), 0u);
    while (!rendered.empty()) board.Acknowledged(pop(rendered));
    EXPECT_THAT(board.LiveLeases(), IsEmpty());
    EXPECT_TRUE(board.Idle());
  }
}

TEST(LeaseBoard, AFrameThatIsBeingMadeReadyKeepsNobodyFromOthers) {
  LeaseBoard board;
  const auto slow = JobOf("slow"), quick = JobOf("quick");
  const uint32_t tiles[] = {0, 1};
  board.Grant(slow, 1, 0, tiles);
  board.Grant(slow, 2, 1, tiles);
  board.Grant(quick, 3, 0, tiles);
  const TileTask at = *board.Take();
  EXPECT_EQ(at.job, slow);
  // The scene is not imported, so another frame of it would wait for the same.
  EXPECT_EQ(Take(board).job, quick);
  EXPECT_EQ(Take(board).job, quick);
  EXPECT_FALSE(board.Starved()) << "no thread is free";
  std::thread waiting([&] {
    const TileTask next = board.Take().value();
    EXPECT_EQ(next.job, slow);
    EXPECT_EQ(next.frame, 0);
    EXPECT_EQ(next.tile, 1u);
  });
  while (!board.Starved()) std::this_thread::yield();
  board.FrameReady(at, true);
  waiting.join();
  // Frame 1 is made ready by one thread alone; frame 0 is ready, and more of it may come.
  const TileTask second = *board.Take();
  EXPECT_EQ(second.frame, 1);
  board.Grant(slow, 4, 0, tiles);
  EXPECT_EQ(Take(board).frame, 0);
  EXPECT_EQ(Take(board).frame, 0);
  board.FrameReady(second, false);
  const TileTask third = *board.Take();
  EXPECT_EQ(third.frame, 1);
  board.Grant(slow, 5, 1, tiles);
  board.Grant(quick, 6, 0, tiles);
  EXPECT_EQ(Take(board).job, quick) << "a frame that could not be made ready is tried by one thread again";
}

}  // namespace
}  // namespace shutterline::worker
