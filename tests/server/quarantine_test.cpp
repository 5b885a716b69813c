// Tiles that cannot be rendered, through the coordinator's services.
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/image/exr.h"
#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::server {
namespace {

using test::FakeWorker;
using testing::ElementsAre;
using testing::HasSubstr;
using Request = v1::ControlRequest;

class QuarantineTest : public test::CoordinatorFixture {
 protected:
  /// A job of frame 3 with two tiles, the first of which fails three times; the job has ended.
  v1::Job PartialJob(FakeWorker& worker) {
    const v1::Job job = SubmitOrDie(TriangleJob(3, 3, 64, 32));
    for (int i = 0; i < 3; ++i) worker.FailNext("too many triangles");
    worker.RenderUntilForgotten();
    return WaitForEnd(job.id());
  }
};

TEST_F(QuarantineTest, FrameIsDeliveredWithoutTheTileNamesItAndTheJobIsPartial) {
  FakeWorker worker(channel_);
  const v1::Job ended = PartialJob(worker);
  EXPECT_EQ(ended.state(), v1::JOB_STATE_PARTIAL);
  EXPECT_THAT(ended.error(),
              HasSubstr("1 tile is missing, the first: frame 3, tile 0: RESOURCE_EXHAUSTED: too many"));
  EXPECT_EQ(ended.frames_finished(), 1u);
  EXPECT_EQ(ended.tiles_done(), 1u);
  EXPECT_EQ(ended.tiles_quarantined(), 1u);

  std::string bytes;
  v1::FrameChunk first;
  ASSERT_TRUE(Fetch(ended.id(), 3, 0, bytes, first).ok());
  ExrMetadata metadata;
  const Image image = DecodeExr(bytes, "frame", &metadata).value();
  EXPECT_EQ(metadata.strings["shutterline:missing_tiles"], "0");
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) {
      float expected[4] = {0, 0, 0, 0};
      if (x >= 32) test::SyntheticPixel(3, x, y, expected);
      ASSERT_THAT(std::vector<float>(image.At(x, y), image.At(x, y) + 4), testing::ElementsAreArray(expected))
          << x << ", " << y;
    }
  }
}

TEST_F(QuarantineTest, EvidenceIsDurableAndRetryRendersJustTheMissingTile) {
  std::string id;
  {
    FakeWorker worker(channel_, "culprit");
    id = PartialJob(worker).id();
  }
  StopCoordinator();
  StartCoordinator();
  const v1::Job job = Get(id);
  EXPECT_EQ(job.state(), v1::JOB_STATE_PARTIAL);
  ASSERT_EQ(job.quarantined_size(), 1);
  EXPECT_EQ(job.quarantined(0).frame(), 3);
  EXPECT_EQ(job.quarantined(0).tile(), 0u);
  ASSERT_EQ(job.quarantined(0).evidence_size(), 3);
  EXPECT_EQ(job.quarantined(0).evidence(2).worker_uuid(), "culprit");
  EXPECT_EQ(job.quarantined(0).evidence(2).worker_name(), "fake worker");
  EXPECT_FALSE(job.quarantined(0).evidence(2).worker_ended());
  EXPECT_THAT(job.quarantined(0).evidence(2).reason(), HasSubstr("too many triangles"));

  const v1::Job again = ControlOrDie(id, Request::ACTION_RETRY);
  EXPECT_EQ(again.state(), v1::JOB_STATE_RUNNING);
  EXPECT_EQ(again.frames_finished(), 0u);
  EXPECT_EQ(again.tiles_done(), 1u);
  EXPECT_EQ(again.tiles_quarantined(), 0u);
  FakeWorker worker(channel_, "better");
  worker.Credit(1);
  const v1::Grant grant = worker.NextGrant();
  EXPECT_THAT(grant.tiles(), ElementsAre(0u));
  worker.Render(grant);
  EXPECT_EQ(WaitForEnd(id).state(), v1::JOB_STATE_SUCCEEDED);
  ExpectSyntheticFrame(id, 3, 64, 32);
}

TEST_F(QuarantineTest, RetryOfARunningJobQueuesTheTileAgain) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 1, 64, 32));
  FakeWorker worker(channel_);
  for (int i = 0; i < 3; ++i) worker.FailNext("no");
  worker.Credit(1);
  worker.Render(worker.NextGrant());
  WatchUntil(job.id(), [](const v1::Job& j) { return j.frames_finished() == 1; });
  EXPECT_EQ(Get(job.id()).state(), v1::JOB_STATE_RUNNING);
  const v1::Job again = ControlOrDie(job.id(), Request::ACTION_RETRY);
  EXPECT_EQ(again.tiles_quarantined(), 0u);
  EXPECT_EQ(again.frames_finished(), 0u);
  worker.RenderUntilForgotten();
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_SUCCEEDED);
  ExpectSyntheticFrame(job.id(), 0, 64, 32);
  ExpectSyntheticFrame(job.id(), 1, 64, 32);
}

TEST_F(QuarantineTest, TileThatKillsThreeWorkersIsQuarantinedWithTheirNames) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 0, 64, 32));
  FakeWorker survivor(channel_, "survivor");
  survivor.Credit(1);
  const v1::Grant good = survivor.NextGrant();  // So that there is one tile for all victims.
  uint32_t deadly = 0;
  for (int i = 0; i < 3; ++i) {
    FakeWorker victim(channel_, absl::StrCat("victim ", i));
    victim.Credit(1);
    const v1::Grant grant = victim.NextGrant();
    ASSERT_EQ(grant.tiles_size(), 1);
    if (i == 0) deadly = grant.tiles(0);
    EXPECT_EQ(grant.tiles(0), deadly);
    victim.Die();
  }
  WatchUntil(job.id(), [](const v1::Job& j) { return j.tiles_quarantined() == 1; });
  survivor.Render(good);
  EXPECT_EQ(WaitForEnd(job.id()).state(), v1::JOB_STATE_PARTIAL);
  const v1::Job ended = Get(job.id());
  ASSERT_EQ(ended.quarantined_size(), 1);
  EXPECT_EQ(ended.quarantined(0).tile(), deadly);
  ASSERT_EQ(ended.quarantined(0).evidence_size(), 3);
  EXPECT_EQ(ended.quarantined(0).evidence(0).worker_uuid(), "victim 0");
  EXPECT_TRUE(ended.quarantined(0).evidence(0).worker_ended());
}

TEST_F(QuarantineTest, JobWhoseFirstThreeTilesFailWithNothingRenderedIsHopeless) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 99, 640, 640));
  FakeWorker worker(channel_);
  for (int i = 0; i < 9; ++i) worker.FailNext("the scene cannot be set up");
  const v1::Job ended = WaitForEnd(job.id());
  EXPECT_EQ(ended.state(), v1::JOB_STATE_FAILED);
  EXPECT_THAT(ended.error(), HasSubstr("the scene cannot be set up"));
  EXPECT_EQ(ended.tiles_quarantined(), 3u);
}

TEST_F(QuarantineTest, MissingTilesAndFinishedFramesOfARunningJobSurviveARestart) {
  const v1::Job job = SubmitOrDie(TriangleJob(0, 1, 64, 32));
  {
    FakeWorker worker(channel_);
    for (int i = 0; i < 3; ++i) worker.FailNext("no");
    worker.Credit(1);
    worker.Render(worker.NextGrant());
    WatchUntil(job.id(), [](const v1::Job& j) { return j.frames_finished() == 1; });
  }
  StopCoordinator();
  StartCoordinator();
  EXPECT_EQ(Get(job.id()).frames_finished(), 1u);
  EXPECT_EQ(Get(job.id()).tiles_quarantined(), 1u);
  FakeWorker worker(channel_);
  worker.RenderUntilForgotten();
  std::vector<v1::JobEvent> events;
  EXPECT_EQ(WaitForEnd(job.id(), &events).state(), v1::JOB_STATE_PARTIAL);
  EXPECT_EQ(std::count_if(events.begin(), events.end(),
                          [](const v1::JobEvent& e) { return e.frame().tiles_missing() == 1; }),
            1);
  ExpectSyntheticFrame(job.id(), 1, 64, 32);
}

}  // namespace
}  // namespace shutterline::server
