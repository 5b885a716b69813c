#include "server/assets/disk_asset_store.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>

#include "common/base/retry_hint.h"
#include "server/assets/blob_scene_source.h"
#include "server/files/file_faults.h"
#include "tests/support/fake_clock.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::server {
namespace {

class DiskAssetStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    auto store = DiskAssetStore::Open(folder_.path(), {.max_blob_bytes = 1000});
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }

  absl::StatusOr<CommittedBlob> Put(const Digest& digest, const std::string& content) {
    auto writer = store_->Write(digest, content.size(), 0);
    if (!writer.ok()) return writer.status();
    const absl::Status appended = (*writer)->Append(content);
    if (!appended.ok()) return appended;
    return (*writer)->Finish();
  }

  std::string PathOf(const Digest& digest) {
    return absl::StrCat(folder_.path(), "/blobs/", digest.ToHex().substr(0, 2), "/", digest.ToHex());
  }

  test::TemporaryFolder folder_;
  std::unique_ptr<DiskAssetStore> store_;
};

TEST_F(DiskAssetStoreTest, BlobIsSeenOnlyWhenItIsCompleteAndTrue) {
  const std::string content = "some bytes";
  const Digest digest = Sha256(content);
  {
    auto writer = store_->Write(digest, content.size(), 0);
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE((*writer)->Append("some ").ok());
    EXPECT_TRUE(absl::IsNotFound(store_->Size(digest).status()));
    EXPECT_TRUE(absl::IsAborted(store_->Write(digest, content.size(), 5).status()));
  }
  EXPECT_EQ(store_->Query(digest)->size, 5u);
  EXPECT_TRUE(absl::IsOutOfRange(store_->Write(digest, content.size(), 4).status()));
  auto writer = store_->Write(digest, content.size(), 5);
  ASSERT_TRUE(writer.ok()) << writer.status();
  ASSERT_TRUE((*writer)->Append("bytes").ok());
  EXPECT_TRUE(absl::IsInvalidArgument((*writer)->Append("!")));
  EXPECT_TRUE((*writer)->Finish()->complete);
  EXPECT_EQ(store_->Read(digest, 5, 3).value(), "byt");
  EXPECT_EQ(store_->ReadVerified(digest, 100).value(), content);
  EXPECT_TRUE(absl::IsResourceExhausted(store_->ReadVerified(digest, 9).status()));
}

TEST_F(DiskAssetStoreTest, WrongBytesAreDropped) {
  const Digest digest = Sha256("right");
  EXPECT_TRUE(absl::IsInvalidArgument(Put(digest, "wrong").status()));
  EXPECT_EQ(store_->Query(digest)->size, 0u);
  EXPECT_TRUE(Put(digest, "right")->complete);
}

TEST_F(DiskAssetStoreTest, WhatAnEarlierWriterLeftIsVerifiedWithTheRest) {
  const std::string content = "some bytes";
  const Digest digest = Sha256(content);
  const auto write = [&](size_t offset, const std::string& bytes) {
    auto writer = store_->Write(digest, content.size(), offset);
    EXPECT_TRUE(writer.ok()) << writer.status();
    EXPECT_TRUE((*writer)->Append(bytes).ok());
    return (*writer)->Finish();
  };
  EXPECT_EQ(write(0, "some ")->size, 5u);
  std::ofstream(absl::StrCat(folder_.path(), "/incoming/", digest.ToHex())) << "SOME ";
  EXPECT_TRUE(absl::IsInvalidArgument(write(5, "bytes").status()));
  EXPECT_EQ(store_->Query(digest)->size, 0u);
  // In three pieces, by three writers.
  EXPECT_FALSE(write(0, "so")->complete);
  EXPECT_FALSE(write(2, "me by")->complete);
  EXPECT_TRUE(write(7, "tes")->complete);
  EXPECT_EQ(store_->ReadVerified(digest, 100).value(), content);
}

TEST_F(DiskAssetStoreTest, AWriteThatFailedHalfWayIsGoneOnWith) {
  /// Writes a byte and then no more.
  class FullDisk final : public FileFaults {
   public:
    Verdict Before(const FileOperation& operation) override {
      if (operation.kind != FileOperation::Kind::kWrite) return {};
      return writes_++ == 0 ? Verdict{.bytes = 1} : Verdict{.error = ENOSPC};
    }

   private:
    int writes_ = 0;
  };
  const std::string content = "some bytes";
  const Digest digest = Sha256(content);
  {
    auto writer = store_->Write(digest, content.size(), 0);
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE((*writer)->Append("some ").ok());
    FullDisk full;
    InstallFileFaults(&full);
    EXPECT_FALSE((*writer)->Append("bytes").ok());
    InstallFileFaults(nullptr);
    // By the same writer, over what was begun.
    EXPECT_TRUE((*writer)->Append("by").ok());
  }
  const uint64_t here = store_->Query(digest)->size;
  ASSERT_EQ(here, 7u);
  auto writer = store_->Write(digest, content.size(), here);
  ASSERT_TRUE(writer.ok()) << writer.status();
  ASSERT_TRUE((*writer)->Append("tes").ok());
  EXPECT_TRUE((*writer)->Finish()->complete);
  EXPECT_EQ(store_->ReadVerified(digest, 100).value(), content);
}

TEST_F(DiskAssetStoreTest, OfABlobThatWasSaidToBeLargerNothingIsLeft) {
  const Digest digest = Sha256("right");
  {
    auto writer = store_->Write(digest, 100, 0);
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE((*writer)->Append("wrong and long").ok());
  }
  EXPECT_TRUE(Put(digest, "right")->complete);
  EXPECT_EQ(store_->ReadVerified(digest, 100).value(), "right");
}

TEST_F(DiskAssetStoreTest, EmptyBlobIsABlobAndALargeOneIsRefused) {
  EXPECT_TRUE(Put(Sha256(""), "")->complete);
  EXPECT_EQ(store_->Size(Sha256("")).value(), 0u);
  EXPECT_TRUE(absl::IsResourceExhausted(store_->Write(Sha256("x"), 1001, 0).status()));
}

TEST_F(DiskAssetStoreTest, DamageIsFoundAndTheBlobCanComeAgain) {
  const Digest digest = Sha256("content");
  ASSERT_TRUE(Put(digest, "content")->complete);
  std::ofstream(PathOf(digest)) << "kontent";
  EXPECT_TRUE(absl::IsDataLoss(store_->ReadVerified(digest, 100).status()));
  EXPECT_TRUE(absl::IsNotFound(store_->Size(digest).status()));
  EXPECT_TRUE(Put(digest, "content")->complete);
}

/// A store of at most 100 bytes, whose blobs are old after a minute.
class BlobLimitTest : public testing::Test {
 protected:
  void SetUp() override { Reopen(); }
  void Reopen() {
    store_.reset();
    auto store = DiskAssetStore::Open(
        folder_.path(), {.limit_bytes = 100, .grace = absl::Minutes(1), .durability = Durability::kProcess},
        clock_);
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }
  /// Uploads so many bytes, all of them `name`, and lets them become old.
  absl::Status Put(char name, size_t bytes) {
    const std::string content(bytes, name);
    auto writer = store_->Write(Sha256(content), bytes, 0);
    if (!writer.ok()) return writer.status();
    const absl::Status appended = (*writer)->Append(content);
    if (!appended.ok()) return appended;
    const auto finished = (*writer)->Finish();
    writer->reset();  // Until then the blob is in use.
    clock_.Advance(absl::Minutes(2));
    return finished.status();
  }
  bool Has(char name, size_t bytes) { return store_->Size(Sha256(std::string(bytes, name))).ok(); }

  test::TemporaryFolder folder_;
  test::FakeClock clock_;
  std::unique_ptr<DiskAssetStore> store_;
};

TEST_F(BlobLimitTest, LeastRecentlyUsedBlobsGoFirst) {
  for (const char name : {'a', 'b', 'c'}) ASSERT_TRUE(Put(name, 30).ok());
  EXPECT_TRUE(Has('a', 30));  // That is a use.
  clock_.Advance(absl::Minutes(2));
  ASSERT_TRUE(Put('d', 30).ok());
  EXPECT_FALSE(Has('b', 30));
  EXPECT_TRUE(Has('a', 30) && Has('c', 30) && Has('d', 30));
  EXPECT_EQ(store_->bytes(), 90u);
}

TEST_F(BlobLimitTest, TheOrderOfUseSurvivesARestart) {
  for (const char name : {'a', 'b', 'c'}) {
    ASSERT_TRUE(Put(name, 30).ok());
    // Times of files are wall times, which a test cannot set forward but can set back.
    const std::string hex = Sha256(std::string(30, name)).ToHex();
    const std::string path = absl::StrCat(folder_.path(), "/blobs/", hex.substr(0, 2), "/", hex);
    std::filesystem::last_write_time(
        path, std::filesystem::file_time_type::clock::now() - std::chrono::hours(name == 'a'   ? 1
                                                                                 : name == 'b' ? 3
                                                                                               : 2));
  }
  Reopen();
  EXPECT_EQ(store_->bytes(), 90u);
  ASSERT_TRUE(Put('d', 40).ok());
  EXPECT_FALSE(Has('b', 30));
  EXPECT_TRUE(Has('a', 30) && Has('c', 30));
}

TEST_F(BlobLimitTest, InputsOfALiveJobAreNotEvictedInMidJob) {
  auto pins = store_->Pin({Sha256(std::string(60, 'a'))});  // Before it is there, as Submit does.
  ASSERT_TRUE(Put('a', 60).ok());
  ASSERT_TRUE(Put('b', 30).ok());
  ASSERT_TRUE(Put('c', 40).ok());
  EXPECT_TRUE(Has('a', 60));
  EXPECT_FALSE(Has('b', 30));
  clock_.Advance(absl::Minutes(2));
  const absl::Status refused = Put('d', 50);
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_TRUE(RetryHint(refused).has_value());
  EXPECT_TRUE(Has('a', 60) && Has('c', 40));  // And nothing went in vain.
  pins.reset();
  clock_.Advance(absl::Minutes(2));
  EXPECT_TRUE(Put('d', 50).ok());
  EXPECT_FALSE(Has('a', 60));
}

TEST_F(BlobLimitTest, FilesOfASceneThatIsBeingUploadedDoNotEvictEachOther) {
  const std::string first(60, 'a');
  {
    auto writer = store_->Write(Sha256(first), 60, 0);
    ASSERT_TRUE(writer.ok() && (*writer)->Append(first).ok() && (*writer)->Finish()->complete);
  }
  EXPECT_TRUE(absl::IsResourceExhausted(store_->Write(Sha256(std::string(60, 'b')), 60, 0).status()));
  EXPECT_TRUE(Has('a', 60));
}

TEST_F(BlobLimitTest, WhatWasBegunAndAbandonedCountsAndGoes) {
  {
    auto writer = store_->Write(Sha256(std::string(90, 'a')), 90, 0);
    ASSERT_TRUE(writer.ok() && (*writer)->Append(std::string(50, 'a')).ok());
    EXPECT_EQ(store_->bytes(), 90u);  // Room is kept for what was announced.
  }
  EXPECT_EQ(store_->bytes(), 50u);
  Reopen();
  EXPECT_EQ(store_->bytes(), 50u);
  ASSERT_TRUE(Put('b', 80).ok());
  EXPECT_EQ(store_->Query(Sha256(std::string(90, 'a')))->size, 0u);
}

TEST_F(DiskAssetStoreTest, SceneSourceOffersTheManifestAndNothingElse) {
  const Digest digest = Sha256("png");
  ASSERT_TRUE(Put(digest, "png")->complete);
  SceneManifest manifest;
  manifest.root_name = "a.gltf";
  manifest.files = {{"textures/wood.png", digest, 3}};
  const BlobSceneSource source(manifest, *store_);
  EXPECT_EQ(source.Read("textures/wood.png", 10).value(), "png");
  EXPECT_EQ(source.Read("./textures/wood.png", 10).value(), "png");
  EXPECT_TRUE(absl::IsNotFound(source.Read("a.gltf", 10).status()));
  for (const char* hostile : {"/etc/passwd", "../a", "textures/../a", "a\\b", "", "a//b"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(source.Read(hostile, 10).status())) << hostile;
  }
}

}  // namespace
}  // namespace shutterline::server
