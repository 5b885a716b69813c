#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tests/worker/fake_coordinator.h"
#include "tests/worker/fake_renderer.h"
#include "worker/worker.h"

namespace shutterline::worker {

using State = FakeCoordinator::State;

/// Which tiles of a frame have come, in order of number; with repetitions.
inline std::multiset<uint32_t> TilesOf(const std::vector<v1::TileResult>& results) {
  std::multiset<uint32_t> tiles;
  for (const v1::TileResult& result : results) tiles.insert(result.tile());
  return tiles;
}

class WorkerTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = (std::filesystem::temp_directory_path() / "worker_session_test.XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    scene_ = coordinator_.PutBlob("a scene of more than one chunk");
  }
  void TearDown() override {
    worker_.reset();
    std::filesystem::remove_all(folder_);
  }

  void StartWorker(int threads = 2, size_t max_result_bytes = 64 << 20,
                   const Clock& clock = Clock::System()) {
    WorkerOptions options;
    options.name = "test worker";
    options.threads = threads;
    options.cache_dir = folder_;
    options.max_result_bytes = max_result_bytes;
    options.backoff_initial = absl::Milliseconds(1);
    options.backoff_max = absl::Milliseconds(10);
    options.drain_patience = patience_;
    auto worker = Worker::Start(coordinator_.Channel(), options, engine_, clock);
    ASSERT_TRUE(worker.ok()) << worker.status();
    worker_ = *std::move(worker);
  }

  /// A job whose frames have 4 × 3 tiles, the last ones of a row and column cut.
  void SendJob(const std::string& id = "job-1") { coordinator_.SendJob(id, 100, 90, scene_); }

  /// Until a heartbeat names no lease, other than one that was on its way already.
  void WaitUntilNothingIsHeld() {
    const size_t before = coordinator_.state().heartbeats.size();
    coordinator_.WaitFor(
        [&](const State& s) { return s.heartbeats.size() >= before + 2 && s.heartbeats.back().empty(); });
  }

  static void ExpectPixels(const v1::TileResult& result) {
    ASSERT_TRUE(result.has_pixels()) << result.failure().message();
    const TileRect rect = TileGrid{100, 90}.Rect(int(result.tile()));
    std::vector<float> expected(size_t(rect.Area()) * 4);
    FakeRenderer::Expected(rect, result.frame(), expected);
    ASSERT_EQ(result.pixels().size(), expected.size() * sizeof(float));
    EXPECT_EQ(std::memcmp(result.pixels().data(), expected.data(), result.pixels().size()), 0);
  }

  std::filesystem::path folder_;
  absl::Duration patience_ = absl::Seconds(30);
  FakeCoordinator coordinator_;
  FakeRenderer engine_;
  Digest scene_;
  std::unique_ptr<Worker> worker_;
};

}  // namespace shutterline::worker
