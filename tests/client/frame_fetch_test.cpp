#include "client/frame_fetch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "client/part_file.h"
#include "common/image/exr.h"
#include "tests/client/fake_farm.h"
#include "tests/client/temp_folder.h"

namespace shutterline::client::frame_fetch_test {
namespace {

constexpr char kJob[] = "0f8fad5b-d9cb-469f-a165-70867728950e";

std::string RandomBytes(std::mt19937& random, size_t count) {
  std::string bytes(count, '\0');
  for (char& c : bytes) c = char(random());
  return bytes;
}

TEST(FrameFetch, ResumesWhereverTheStreamIsCut) {
  const uint32_t seed = std::random_device{}();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 20; ++round) {
    FakeFarm farm;
    TempFolder folder;
    const size_t size = std::uniform_int_distribution<size_t>(0, 20'000)(random);
    farm.frames[5] = RandomBytes(random, size);
    farm.chunk_bytes = std::uniform_int_distribution<size_t>(1, 3000)(random);
    for (int i = 0; i < 8; ++i) farm.cuts.push_back(std::uniform_int_distribution<uint64_t>(0, 4000)(random));
    const auto connection = farm.Connect();
    const auto frame = FetchFrame(*connection, kJob, 5, folder.File("f.exr"), false);
    ASSERT_TRUE(frame.ok()) << frame.status();
    EXPECT_EQ(folder.Read("f.exr"), farm.frames[5]);
    EXPECT_EQ(farm.bytes_sent, size) << "no byte travels twice";
    EXPECT_TRUE(std::is_sorted(farm.offsets.begin(), farm.offsets.end()));
    EXPECT_EQ(folder.Count(), 1u) << "nothing is left beside the frame";
  }
}

TEST(FrameFetch, WrongDigestLeavesTheOldFileAlone) {
  FakeFarm farm;
  TempFolder folder;
  folder.Write("f.exr", "old");
  farm.frames[5] = std::string(5000, 'a');
  farm.digest_of[5] = "other bytes";
  const auto frame = FetchFrame(*farm.Connect(), kJob, 5, folder.File("f.exr"), false);
  EXPECT_EQ(frame.status().code(), absl::StatusCode::kDataLoss) << frame.status();
  EXPECT_NE(frame.status().message().find(Sha256("other bytes").ToHex()), absl::string_view::npos);
  EXPECT_EQ(folder.Read("f.exr"), "old");
  EXPECT_EQ(folder.Count(), 1u);
}

TEST(FrameFetch, GoesOnWithWhatAnEarlierProcessLeft) {
  FakeFarm farm;
  TempFolder folder;
  std::mt19937 random(1);
  farm.frames[5] = RandomBytes(random, 10'000);
  {
    auto part = PartFile::Open(folder.File("f.exr"), std::string(kJob) + "-5");
    ASSERT_TRUE(part.ok()) << part.status();
    ASSERT_TRUE((*part)->Append(farm.frames[5].substr(0, 6000)).ok());
  }
  const auto frame = FetchFrame(*farm.Connect(), kJob, 5, folder.File("f.exr"), false);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(farm.bytes_sent, 4000u);
  EXPECT_EQ(folder.Read("f.exr"), farm.frames[5]);
}

TEST(FrameFetch, LeftoversOfAnotherFileAreDropped) {
  for (const size_t leftover : {size_t{100}, size_t{9999}, size_t{50'000}}) {
    FakeFarm farm;
    TempFolder folder;
    std::mt19937 random(2);
    farm.frames[5] = RandomBytes(random, 10'000);
    {
      auto part = PartFile::Open(folder.File("f.exr"), std::string(kJob) + "-5");
      ASSERT_TRUE(part.ok());
      ASSERT_TRUE((*part)->Append(std::string(leftover, 'z')).ok());
    }
    const auto frame = FetchFrame(*farm.Connect(), kJob, 5, folder.File("f.exr"), false);
    ASSERT_TRUE(frame.ok()) << leftover << ": " << frame.status();
    EXPECT_EQ(folder.Read("f.exr"), farm.frames[5]);
  }
}

TEST(FrameFetch, UnfinishedFrameIsAFailedPrecondition) {
  FakeFarm farm;
  TempFolder folder;
  const auto frame = FetchFrame(*farm.Connect(), kJob, 9, folder.File("f.exr"), false);
  EXPECT_EQ(frame.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(folder.Count(), 0u);
}

TEST(FrameFetch, NamesTheFolderThatIsMissing) {
  FakeFarm farm;
  TempFolder folder;
  farm.frames[1] = "x";
  const auto frame = FetchFrame(*farm.Connect(), kJob, 1, folder.File("no/f.exr"), false);
  EXPECT_EQ(frame.status().code(), absl::StatusCode::kNotFound);
  EXPECT_NE(frame.status().message().find("no/f.exr"), absl::string_view::npos);
}

TEST(FrameFetch, WritesThePreviewBesideTheFrame) {
  FakeFarm farm;
  TempFolder folder;
  Image image(40, 33);
  for (float& value : image.values()) value = 0.5f;
  const auto exr = EncodeExr(image, {}, {});
  ASSERT_TRUE(exr.ok()) << exr.status();
  farm.frames[1] = *exr;
  const auto frame = FetchFrame(*farm.Connect(), kJob, 1, folder.File("f.exr"), true);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->preview, folder.File("f.png"));
  EXPECT_EQ(folder.Read("f.png").substr(0, 4), "\x89PNG");
  EXPECT_EQ(frame->digest, Sha256(*exr));
}

TEST(PartFile, TwoWritersExcludeOneAnother) {
  TempFolder folder;
  auto first = PartFile::Open(folder.File("f.exr"), "a");
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(PartFile::Open(folder.File("f.exr"), "a").status().code(), absl::StatusCode::kUnavailable);
  EXPECT_TRUE(PartFile::Open(folder.File("f.exr"), "b").ok());
}

}  // namespace
}  // namespace shutterline::client::frame_fetch_test
