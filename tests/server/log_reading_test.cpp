#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/ids.h"
#include "common/base/log.h"
#include "tests/server/coordinator_fixture.h"
#include "tests/server/fake_worker.h"

namespace shutterline::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class LogReadingTest : public CoordinatorFixture {
 protected:
  // The fixture's coordinator listens already; the log begins here.
  LogReadingTest() { EXPECT_TRUE(SetUpLog("server", "off").ok()); }

  grpc::Status Read(const std::string& job, uint64_t offset, std::string& text) {
    grpc::ClientContext context;
    v1::LogRequest request;
    request.set_job_id(job);
    request.set_offset(offset);
    const auto reader = jobs_->ReadLog(&context, request);
    v1::LogChunk chunk;
    while (reader->Read(&chunk)) {
      EXPECT_EQ(chunk.offset(), offset + text.size());
      text += chunk.data();
    }
    return reader->Finish();
  }
};

TEST_F(LogReadingTest, TellsWhatHappenedToAJobAlsoAfterARestart) {
  const v1::Job job = SubmitOrDie(TriangleJob(4, 4, 32, 32));
  const v1::Job other = SubmitOrDie(TriangleJob(1, 1, 32, 32));
  FakeWorker worker(channel_);
  worker.Credit(1);
  const v1::Grant grant = worker.NextGrant();
  ASSERT_EQ(grant.job_id(), job.id());
  v1::TileResult result = worker.Result(grant, 0);
  result.mutable_failure()->set_code(8);
  result.mutable_failure()->set_message("too many triangles");
  worker.Push({result});
  StopCoordinator();
  StartCoordinator();

  std::string text;
  ASSERT_TRUE(Read(job.id(), 0, text).ok());
  EXPECT_THAT(text,
              AllOf(HasSubstr("job accepted"), HasSubstr("frame=4 tile=0"), HasSubstr("too many triangles"),
                    HasSubstr("job taken up again"), Not(HasSubstr(other.id()))));
  std::string rest;
  ASSERT_TRUE(Read(job.id(), 10, rest).ok());
  EXPECT_EQ(rest, text.substr(10));
  std::string beyond;
  EXPECT_TRUE(Read(job.id(), uint64_t{1} << 60, beyond).ok());
  EXPECT_EQ(beyond, "");
}

TEST_F(LogReadingTest, JobsThatAreNotThereHaveNoLog) {
  std::string text;
  EXPECT_EQ(Read(MakeUuid(), 0, text).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Read("../../etc/passwd", 0, text).error_code(), grpc::StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace shutterline::test
