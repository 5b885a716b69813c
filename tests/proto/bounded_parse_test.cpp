#include "proto/convert/bounded_parse.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "shutterline/v1/jobs.pb.h"
#include "shutterline/v1/workers.pb.h"

namespace shutterline::convert {
namespace {

using testing::HasSubstr;

TEST(BoundedParse, TakesWhatIsWithinTheBoundAndCountsEveryLevel) {
  v1::DigestList list;
  for (int i = 0; i < 10; ++i) list.add_digests()->set_sha256(std::string(32, 'x'));
  const std::string bytes = list.SerializeAsString();
  v1::DigestList read;
  EXPECT_TRUE(ParseBounded(bytes, 20, read).ok());
  EXPECT_EQ(read.SerializeAsString(), bytes);
  EXPECT_THAT(std::string(ParseBounded(bytes, 19, read).message()), HasSubstr("more fields"));
}

TEST(BoundedParse, CountsPackedNumbersAndUnknownFields) {
  v1::Heartbeat beat;
  for (int i = 0; i < 100; ++i) beat.add_lease_ids(1);
  EXPECT_TRUE(ParseBounded(beat.SerializeAsString(), 101, beat).ok());
  EXPECT_EQ(beat.lease_ids_size(), 100);
  EXPECT_FALSE(ParseBounded(beat.SerializeAsString(), 100, beat).ok());
  const std::string unknown(200, '\x78');  // Field 15, number 0x78, a hundred times.
  EXPECT_TRUE(ParseBounded(unknown, 100, beat).ok());
  EXPECT_FALSE(ParseBounded(unknown, 99, beat).ok());
}

TEST(BoundedParse, RefusesGroupsAndWhatIsCutOff) {
  v1::JobRef job;
  EXPECT_THAT(std::string(ParseBounded("\x7b\x7c", 100, job).message()), HasSubstr("groups"));
  job.set_job_id("0123456789");
  const std::string bytes = job.SerializeAsString();
  for (size_t cut = 1; cut < bytes.size(); ++cut) {
    EXPECT_TRUE(absl::IsInvalidArgument(ParseBounded(bytes.substr(0, cut), 100, job))) << cut;
  }
  EXPECT_TRUE(ParseBounded("", 100, job).ok());
  EXPECT_FALSE(ParseBounded(std::string("\x0a\x02\xff\xfe", 4), 100, job).ok())
      << "a string that is no UTF-8";
}

TEST(BoundedParse, AgreesWithTheLibraryOnMutants) {
  constexpr uint64_t kSeed = 20261126;
  std::mt19937_64 random(kSeed);
  v1::SubmitRequest request;
  request.set_request_id("wish");
  request.mutable_spec()->mutable_scene()->add_files()->set_name("fox.glb");
  request.mutable_spec()->mutable_render()->set_width(64);
  const std::string good = request.SerializeAsString();
  int taken = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes = good;
    for (int k = 0; k < 2; ++k) bytes[random() % bytes.size()] = char(random());
    v1::SubmitRequest ours, theirs;
    const absl::Status status = ParseBounded(bytes, 1000, ours);
    const bool parsed = theirs.ParseFromString(bytes);
    if (status.ok()) {
      ++taken;
      ASSERT_TRUE(parsed) << "seed " << kSeed << " case " << i;
      ASSERT_EQ(ours.SerializeAsString(), theirs.SerializeAsString());
    } else if (parsed) {
      ASSERT_THAT(std::string(status.message()), HasSubstr("groups")) << "seed " << kSeed << " case " << i;
    }
  }
  EXPECT_GT(taken, 1000);
}

}  // namespace
}  // namespace shutterline::convert
