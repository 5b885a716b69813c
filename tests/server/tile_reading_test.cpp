#include <gtest/gtest.h>

#include <map>

#include "common/base/ids.h"
#include "common/job/tile.h"
#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::test {
namespace {

using Pictures = std::map<uint32_t, std::vector<float>>;

class TileReadingTest : public CoordinatorFixture {
 protected:
  struct Call {
    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReader<v1::TileUpdate>> reader;
  };
  std::unique_ptr<Call> Begin(const std::string& job, int frame, uint32_t side) {
    auto call = std::make_unique<Call>();
    v1::TilesRequest request;
    request.set_job_id(job);
    request.set_frame(frame);
    request.set_side(side);
    call->reader = jobs_->ReadTiles(&call->context, request);
    return call;
  }
  /// Until so many tiles have come, or the stream ends.
  static void ReadSome(Call& call, size_t count, Pictures& pictures) {
    v1::TileUpdate update;
    while (pictures.size() < count && call.reader->Read(&update)) {
      for (const v1::TilePicture& tile : update.tiles()) {
        const bool is_new =
            pictures.emplace(tile.tile(), std::vector<float>(tile.rgba().begin(), tile.rgba().end())).second;
        EXPECT_TRUE(is_new) << "tile " << tile.tile() << " came twice";
      }
    }
  }
  grpc::Status ReadAll(Call& call, Pictures& pictures) {
    ReadSome(call, size_t(-1), pictures);
    return call.reader->Finish();
  }
  /// Renders the next lease, of a job's first tile alone.
  static void RenderOne(FakeWorker& worker) {
    worker.Credit(1);
    worker.Render(worker.NextGrant());
  }
};

TEST_F(TileReadingTest, TilesComeOnceEachAsTheyAreStoredAndTheRestFromTheFile) {
  const v1::Job job = SubmitOrDie(TriangleJob(1, 1, 70, 40));  // 3 × 2 tiles, cut at two borders.
  const auto call = Begin(job.id(), 1, 2);
  FakeWorker worker(channel_);
  RenderOne(worker);
  Pictures live;
  ReadSome(*call, 1, live);
  ASSERT_EQ(live.size(), 1u);
  worker.RenderUntilForgotten();
  ASSERT_TRUE(ReadAll(*call, live).ok());
  EXPECT_EQ(live.size(), 6u);

  // Who comes late reads the same from the finished file.
  Pictures late;
  ASSERT_TRUE(ReadAll(*Begin(job.id(), 1, 2), late).ok());
  EXPECT_EQ(late, live);

  // Each mean is that of its quarter of the tile.
  Pictures pixels;
  ASSERT_TRUE(ReadAll(*Begin(job.id(), 1, kTileSize), pixels).ok());
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) {
      double sum = 0;
      for (int v = 0; v < 16; ++v) {
        for (int u = 0; u < 16; ++u)
          sum += double(pixels.at(0)[size_t(((16 * y + v) * 32 + 16 * x + u) * 4)]);
      }
      EXPECT_NEAR(live.at(0)[size_t((2 * y + x) * 4)], sum / 256, 1e-5);
    }
  }
  // Of a tile that is 6 pixels wide and 8 high, 32 means a side repeat pixels.
  EXPECT_EQ(pixels.at(5).size(), 32u * 32u * 4u);
}

TEST_F(TileReadingTest, ACancelledJobEndsTheStream) {
  const v1::Job job = SubmitOrDie(TriangleJob(1, 1, 64, 64));
  const auto call = Begin(job.id(), 1, 4);
  FakeWorker worker(channel_);
  RenderOne(worker);
  Pictures some;
  ReadSome(*call, 1, some);
  v1::Job cancelled;
  ASSERT_TRUE(Cancel(job.id(), cancelled).ok());
  EXPECT_TRUE(ReadAll(*call, some).ok());
  EXPECT_LT(some.size(), 4u);
}

TEST_F(TileReadingTest, BadRequestsAreNamed) {
  const v1::Job job = SubmitOrDie(TriangleJob(1, 1, 64, 64));
  Pictures none;
  EXPECT_EQ(ReadAll(*Begin(job.id(), 1, 0), none).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(ReadAll(*Begin(job.id(), 1, 33), none).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(ReadAll(*Begin(job.id(), 2, 4), none).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReadAll(*Begin(MakeUuid(), 1, 4), none).error_code(), grpc::StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace shutterline::test
