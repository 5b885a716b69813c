// What a coordinator knows of jobs, frames and tiles after it was started again.
#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::server {
namespace {

using test::CoordinatorFixture;
using test::FakeWorker;

class CoordinatorRestartTest : public CoordinatorFixture {};

/// How a job's frames stood at last.
std::map<int, v1::FrameStatus> LastOf(const std::vector<v1::JobEvent>& events) {
  std::map<int, v1::FrameStatus> frames;
  for (const v1::JobEvent& event : events) {
    if (event.has_frame()) frames[event.frame().frame()] = event.frame();
  }
  return frames;
}

TEST_F(CoordinatorRestartTest, RestartKeepsAcknowledgedTilesAndFinishesTheJob) {
  const v1::Job job = SubmitOrDie(TriangleJob(5, 6, 128, 64));  // 8 tiles a frame.
  v1::Welcome before;
  int acknowledged = 0;
  {
    FakeWorker worker(channel_);
    before = worker.welcome();
    while (acknowledged < 5) {
      worker.Credit(1);
      const v1::ResultAck ack = worker.Render(worker.NextGrant());
      for (const int outcome : ack.outcomes()) EXPECT_EQ(outcome, v1::ResultAck::OUTCOME_STORED);
      acknowledged += ack.outcomes_size();
    }
  }
  StopCoordinator();
  StartCoordinator();
  EXPECT_EQ(Get(job.id()).tiles_done(), uint64_t(acknowledged));
  FakeWorker worker(channel_);
  EXPECT_EQ(worker.welcome().epoch(), before.epoch() + 1);
  worker.RenderUntilForgotten();
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
  ExpectSyntheticFrame(job.id(), 5, 128, 64);
  ExpectSyntheticFrame(job.id(), 6, 128, 64);
  StopCoordinator();
  StartCoordinator();  // An ended job and its frames are still there.
  EXPECT_EQ(Get(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
  EXPECT_EQ(WaitForEnd(job.id()).frames_finished(), 2u);
  ExpectSyntheticFrame(job.id(), 6, 128, 64);
}

TEST_F(CoordinatorRestartTest, WhatTilesTookIsSummedOncePerTileAndSurvivesARestart) {
  const v1::Job job = SubmitOrDie(TriangleJob(1, 2, 64, 64));  // 4 tiles a frame.
  {
    FakeWorker worker(channel_);
    worker.Credit(1);
    const v1::Grant grant = worker.NextGrant();
    worker.Render(grant);
    const v1::ResultAck again = worker.Render(grant);
    for (const int outcome : again.outcomes()) EXPECT_EQ(outcome, v1::ResultAck::OUTCOME_DUPLICATE);
    worker.RenderUntilForgotten();
  }
  for (const bool restarted : {false, true}) {
    if (restarted) {
      StopCoordinator();
      StartCoordinator();
    }
    std::vector<v1::JobEvent> events;
    WaitForEnd(job.id(), &events);
    const std::map<int, v1::FrameStatus> frames = LastOf(events);
    ASSERT_EQ(frames.size(), 2u);
    for (const auto& [number, frame] : frames) {
      EXPECT_EQ(frame.stats().tiles(), 4) << number;
      EXPECT_EQ(frame.stats().lines(), 4 * 100 + 0 + 1 + 2 + 3) << number;
      EXPECT_EQ(frame.stats().shade_seconds(), 1.0) << number;
    }
  }
}

TEST_F(CoordinatorRestartTest, OfAnUnfinishedFrameARestartForgetsWhatItsTilesTook) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 256, 64));  // 16 tiles.
  int before = 0;
  {
    FakeWorker worker(channel_);
    worker.Credit(1);
    before = worker.Render(worker.NextGrant()).outcomes_size();
    ASSERT_LT(before, 16);
  }
  StopCoordinator();
  StartCoordinator();
  FakeWorker worker(channel_);
  worker.RenderUntilForgotten();
  std::vector<v1::JobEvent> events;
  WaitForEnd(job.id(), &events);
  EXPECT_EQ(LastOf(events)[0].tiles_done(), 16u);
  EXPECT_EQ(LastOf(events)[0].stats().tiles(), 16 - before);
}

}  // namespace
}  // namespace shutterline::server
