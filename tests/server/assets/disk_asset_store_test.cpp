#include "server/assets/disk_asset_store.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "server/assets/blob_scene_source.h"
#include "tests/support/temporary_folder.h"

namespace shutterline::server {
namespace {

class DiskAssetStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    auto store = DiskAssetStore::Open(folder_.path(), 1000);
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
