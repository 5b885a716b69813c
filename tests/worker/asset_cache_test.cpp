#include "worker/assets/asset_cache.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <thread>

#include "worker/assets/blob_asset_source.h"

namespace shutterline::worker {
namespace {

namespace fs = std::filesystem;

/// Blobs in memory; counts what is asked for.
class MapFetcher final : public BlobFetcher {
 public:
  Digest Put(const std::string& bytes) {
    blobs[Sha256(bytes)] = bytes;
    return Sha256(bytes);
  }
  absl::StatusOr<std::string> Fetch(const Digest& digest, uint64_t) override {
    ++fetches;
    const auto blob = blobs.find(digest);
    if (blob == blobs.end()) return absl::NotFoundError("no such blob");
    return blob->second;
  }
  std::map<Digest, std::string> blobs;
  std::atomic<int> fetches = 0;
};

class AssetCacheTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = (fs::temp_directory_path() / "asset_cache_test.XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::unique_ptr<AssetCache> Open(uint64_t max_bytes = 1 << 20) {
    auto cache = AssetCache::Open({.folder = folder_, .max_bytes = max_bytes});
    EXPECT_TRUE(cache.ok()) << cache.status();
    return *std::move(cache);
  }
  fs::path FileOf(const Digest& digest) const {
    return folder_ / digest.ToHex().substr(0, 2) / digest.ToHex();
  }

  fs::path folder_;
  MapFetcher fetcher_;
};

TEST_F(AssetCacheTest, FetchesOnceAlsoOverRestarts) {
  const Digest digest = fetcher_.Put("a scene");
  for (int start = 0; start < 3; ++start) {
    const auto cache = Open();
    EXPECT_EQ(cache->Get(digest, 100, fetcher_).value(), "a scene");
    EXPECT_EQ(cache->Get(digest, 100, fetcher_).value(), "a scene");
    EXPECT_EQ(cache->stored_bytes(), 7u);
  }
  EXPECT_EQ(fetcher_.fetches, 1);
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
}

TEST_F(AssetCacheTest, CorruptTornAndEmptiedFilesAreFetchedAgain) {
  const std::string good(10'000, 'x');
  const Digest digest = fetcher_.Put(good);
  std::string flipped = good;
  flipped[5000] ^= 1;
  const auto cache = Open();
  ASSERT_TRUE(cache->Get(digest, 1 << 20, fetcher_).ok());
  int expected = 1;
  for (const std::string& bad : {flipped, good.substr(0, 4096), std::string()}) {
    std::ofstream(FileOf(digest), std::ios::binary | std::ios::trunc) << bad;
    EXPECT_EQ(cache->Get(digest, 1 << 20, fetcher_).value(), good);
    EXPECT_EQ(fetcher_.fetches, ++expected);
    EXPECT_EQ(cache->Get(digest, 1 << 20, fetcher_).value(), good) << "was not stored again";
    EXPECT_EQ(fetcher_.fetches, expected);
    EXPECT_EQ(cache->stored_bytes(), good.size());
  }
}

TEST_F(AssetCacheTest, DeletedFilesAreFetchedAgain) {
  const Digest digest = fetcher_.Put("gone");
  const auto cache = Open();
  ASSERT_TRUE(cache->Get(digest, 100, fetcher_).ok());
  fs::remove(FileOf(digest));  // As another worker that shares the folder may.
  EXPECT_EQ(cache->Get(digest, 100, fetcher_).value(), "gone");
  EXPECT_EQ(cache->stored_bytes(), 4u);
}

TEST_F(AssetCacheTest, WrongBytesFromTheOtherSideAreDataLoss) {
  const Digest digest = Sha256("right");
  fetcher_.blobs[digest] = "wrong";
  const auto cache = Open();
  EXPECT_EQ(cache->Get(digest, 100, fetcher_).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_FALSE(cache->Contains(digest));
  EXPECT_FALSE(fs::exists(FileOf(digest)));
}

TEST_F(AssetCacheTest, LimitHoldsForBlobsOnDiskAndNew) {
  const Digest digest = fetcher_.Put("123456");
  const auto cache = Open();
  EXPECT_EQ(cache->Get(digest, 5, fetcher_).status().code(), absl::StatusCode::kResourceExhausted);
  ASSERT_TRUE(cache->Get(digest, 6, fetcher_).ok());
  EXPECT_EQ(cache->Get(digest, 5, fetcher_).status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(cache->Get(Sha256("unknown"), 5, fetcher_).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(AssetCacheTest, EvictsTheLeastRecentlyUsed) {
  std::vector<Digest> digests;
  for (int i = 0; i < 6; ++i) digests.push_back(fetcher_.Put(std::string(100, char('a' + i))));
  const auto cache = Open(350);
  for (int i : {0, 1, 2, 0, 3}) ASSERT_TRUE(cache->Get(digests[size_t(i)], 100, fetcher_).ok());
  EXPECT_FALSE(cache->Contains(digests[1]));
  EXPECT_FALSE(fs::exists(FileOf(digests[1])));
  for (int i : {0, 2, 3}) EXPECT_TRUE(cache->Contains(digests[size_t(i)])) << i;
  EXPECT_EQ(cache->stored_bytes(), 300u);
}

TEST_F(AssetCacheTest, OrderOfUseSurvivesRestarts) {
  const Digest old = fetcher_.Put(std::string(100, 'o')), recent = fetcher_.Put(std::string(100, 'r'));
  {
    const auto cache = Open();
    ASSERT_TRUE(cache->Get(recent, 100, fetcher_).ok());
    ASSERT_TRUE(cache->Get(old, 100, fetcher_).ok());
  }
  fs::last_write_time(FileOf(old), fs::file_time_type::clock::now() - std::chrono::hours(1));
  const auto cache = Open(150);  // A smaller limit takes effect at once.
  EXPECT_FALSE(cache->Contains(old));
  EXPECT_TRUE(cache->Contains(recent));
}

TEST_F(AssetCacheTest, PinnedBlobsStay) {
  std::vector<Digest> digests;
  for (int i = 0; i < 5; ++i) digests.push_back(fetcher_.Put(std::string(100, char('a' + i))));
  const auto cache = Open(200);
  auto first = cache->MakePin(digests[0]);  // Before it is there.
  auto again = cache->MakePin(digests[0]);
  for (const Digest& digest : digests) ASSERT_TRUE(cache->Get(digest, 100, fetcher_).ok());
  EXPECT_TRUE(cache->Contains(digests[0]));
  EXPECT_EQ(cache->stored_bytes(), 200u);

  auto pins = std::vector<std::unique_ptr<AssetCache::Pin>>();
  for (const Digest& digest : digests) pins.push_back(cache->MakePin(digest));
  for (const Digest& digest : digests) ASSERT_TRUE(cache->Get(digest, 100, fetcher_).ok());
  EXPECT_EQ(cache->stored_bytes(), 500u) << "pinned blobs may exceed the limit";
  pins.clear();
  EXPECT_EQ(cache->stored_bytes(), 200u) << "and go when they are not pinned any more";
  EXPECT_TRUE(cache->Contains(digests[0]));
  first.reset();
  EXPECT_TRUE(cache->Contains(digests[0])) << "one pin is left";
  ASSERT_TRUE(cache->Get(digests[1], 100, fetcher_).ok());
  ASSERT_TRUE(cache->Get(digests[2], 100, fetcher_).ok());
  EXPECT_TRUE(cache->Contains(digests[0]));
}

TEST_F(AssetCacheTest, FilesOfOthersAreLeftAlone) {
  std::ofstream(folder_ / "notes.txt") << "mine";
  fs::create_directory(folder_ / "zz");
  std::ofstream(folder_ / "zz" / Sha256("misplaced").ToHex()) << "misplaced";
  const auto cache = Open(1);
  EXPECT_EQ(cache->stored_bytes(), 0u);
  EXPECT_TRUE(fs::exists(folder_ / "notes.txt"));
}

TEST_F(AssetCacheTest, ManyThreadsManyBlobsSmallLimit) {
  std::vector<std::string> contents;
  for (int i = 0; i < 20; ++i) {
    contents.push_back(std::string(1000, char('a' + i)));
    fetcher_.Put(contents.back());
  }
  const auto cache = Open(5000);
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 200; ++i) {
        const std::string& content = contents[size_t(i * (t + 1)) % contents.size()];
        const auto got = cache->Get(Sha256(content), 1000, fetcher_);
        if (!got.ok() || *got != content) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(cache->stored_bytes(), 5000u);
}

TEST_F(AssetCacheTest, UnusableFolderIsAnError) {
  std::ofstream(folder_ / "file") << "x";
  const auto cache = AssetCache::Open({.folder = folder_ / "file"});
  ASSERT_FALSE(cache.ok());
  EXPECT_NE(std::string(cache.status().message()).find("file"), std::string::npos);
}

TEST_F(AssetCacheTest, SourceOffersWhatTheManifestListsAndNothingElse) {
  const Digest root = fetcher_.Put("root"), buffer = fetcher_.Put("buffer");
  fetcher_.Put("secret");
  const auto cache = Open();
  const auto source = BlobAssetSource::Make(
      {"scene.gltf", {{"scene.gltf", root, 4}, {"data/b 0.bin", buffer, 6}}}, *cache, fetcher_);
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->RootName(), "scene.gltf");
  EXPECT_EQ((*source)->Read("scene.gltf", 100).value(), "root");
  EXPECT_EQ((*source)->Read("./data/x/../b 0.bin", 100).value(), "buffer");
  EXPECT_EQ((*source)->Read("other.bin", 100).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ((*source)->Read("data/b 0.bin", 5).status().code(), absl::StatusCode::kResourceExhausted);
  for (const char* bad : {"", ".", "/etc/passwd", "../up.bin", "data/../../up.bin", "file:///etc/passwd",
                          "http://host/x", "C:/x", "a\\..\\b"}) {
    EXPECT_EQ((*source)->Read(bad, 100).status().code(), absl::StatusCode::kInvalidArgument) << bad;
  }
}

TEST_F(AssetCacheTest, ManifestsThatMakeNoSenseAreRefused) {
  const auto cache = Open();
  const Digest d = Sha256("x");
  const std::vector<SceneManifest> bad = {
      {"a.gltf", {}},
      {"a.gltf", {{"b.gltf", d, 1}}},
      {"a.gltf", {{"a.gltf", d, 1}, {"./a.gltf", d, 1}}},
      {"a.gltf", {{"a.gltf", d, 1}, {"/b", d, 1}}},
      {"../a.gltf", {{"../a.gltf", d, 1}}},
  };
  for (size_t i = 0; i < bad.size(); ++i) {
    EXPECT_EQ(BlobAssetSource::Make(bad[i], *cache, fetcher_).status().code(),
              absl::StatusCode::kInvalidArgument)
        << i;
  }
}

}  // namespace
}  // namespace shutterline::worker
