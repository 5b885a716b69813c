#include "worker/frames/frame_cache.h"

#include <absl/synchronization/barrier.h>
#include <absl/synchronization/notification.h>
#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "tests/support/fake_clock.h"
#include "tests/worker/fake_renderer.h"

namespace shutterline::worker {
namespace {

class OneFile final : public engine::AssetSource {
 public:
  const std::string& RootName() const override { return name_; }
  absl::StatusOr<std::string> Read(absl::string_view, uint64_t) const override { return name_; }

 private:
  const std::string name_ = "scene.gltf";
};

absl::StatusOr<std::unique_ptr<engine::AssetSource>> OpenSource() {
  return std::make_unique<OneFile>();
}

TEST(FrameCache, ImportsOnceAndMakesEachFrameOnce) {
  FakeRenderer engine;
  FrameCache cache(engine, {.max_scenes = 2, .max_frames = 4});
  const Digest scene = Sha256("scene");
  RenderSettings settings, other;
  other.width = 8;
  for (int round = 0; round < 3; ++round) {
    for (int frame = 0; frame < 2; ++frame) {
      ASSERT_TRUE(cache.Get(scene, frame, settings, OpenSource).ok());
      ASSERT_TRUE(cache.Get(scene, frame, other, OpenSource).ok());
    }
  }
  EXPECT_EQ(engine.imports, 1);
  EXPECT_EQ(engine.frames, 4) << "settings are part of a frame's identity";
}

TEST(FrameCache, TakesASceneFromTheShelfOnceAndNoOther) {
  FakeRenderer engine;
  engine::SceneShelf shelf;
  FrameCache cache(engine, {.max_scenes = 1, .shelf = &shelf});
  const auto scene = std::make_shared<const engine::Scene>();
  shelf.Put(Sha256("scene"), scene);
  ASSERT_TRUE(cache.Get(Sha256("other"), 0, RenderSettings(), OpenSource).ok());
  EXPECT_EQ(engine.imports, 1) << "the shelf holds another scene";
  const auto closed = []() -> absl::StatusOr<std::unique_ptr<engine::AssetSource>> {
    return absl::UnavailableError("no file needs to be read");
  };
  EXPECT_TRUE(cache.Get(Sha256("scene"), 0, RenderSettings(), closed).ok());
  EXPECT_EQ(engine.imports, 1);
  EXPECT_EQ(shelf.Take(Sha256("scene")), nullptr) << "the cache alone keeps it alive";
}

TEST(FrameCache, StaysWithinItsBounds) {
  FakeRenderer engine;
  FrameCache cache(engine, {.max_scenes = 2, .max_frames = 3});
  std::vector<std::shared_ptr<const FrameRenderer>> held;
  for (int i = 0; i < 20; ++i) {
    held.push_back(cache.Get(Sha256(std::to_string(i % 5)), i, RenderSettings(), OpenSource).value());
    EXPECT_LE(cache.scene_count(), 2u);
    EXPECT_LE(cache.frame_count(), 3u);
  }
  // What was dropped is still whole for those who hold it.
  std::vector<float> pixels(4);
  engine::RenderStats stats;
  EXPECT_TRUE(held[0]->Render({0, 0, 1, 1}, pixels, stats).ok());
  // The latest three are there, the first is made anew.
  const int made = engine.frames;
  for (int i = 17; i < 20; ++i) {
    ASSERT_TRUE(cache.Get(Sha256(std::to_string(i % 5)), i, RenderSettings(), OpenSource).ok());
  }
  EXPECT_EQ(engine.frames, made);
  ASSERT_TRUE(cache.Get(Sha256("0"), 0, RenderSettings(), OpenSource).ok());
  EXPECT_EQ(engine.frames, made + 1);
}

TEST(FrameCache, WhatTookTooLongIsTriedAgainWhenAsMuchTimeHasPassed) {
  FakeRenderer engine;
  test::FakeClock clock;
  FrameCache cache(engine, {.retry_late = absl::Seconds(10)}, clock);
  engine.before_import = [] { return absl::DeadlineExceededError("it took longer than the 10s"); };
  const auto get = [&](int frame) {
    return cache.Get(Sha256("s"), frame, RenderSettings(), OpenSource).status().code();
  };
  for (int frame = 0; frame < 9; ++frame) EXPECT_EQ(get(frame % 3), absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(engine.imports, 1);
  clock.Advance(absl::Seconds(11));
  EXPECT_EQ(get(0), absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(engine.imports, 2);
  engine.before_import = nullptr;
  clock.Advance(absl::Seconds(11));
  EXPECT_EQ(get(0), absl::StatusCode::kOk);
  clock.Advance(absl::Hours(1));
  EXPECT_EQ(get(0), absl::StatusCode::kOk);
  EXPECT_EQ(engine.imports, 3) << "what could be imported is kept";
}

TEST(FrameCache, ThreadsThatWantTheSameFrameWaitForOne) {
  FakeRenderer engine;
  absl::Notification importing;
  constexpr int kThreads = 4;
  engine.before_import = [&] {
    importing.Notify();  // Would die if a second import began.
    return absl::OkStatus();
  };
  FrameCache cache(engine, {});
  std::vector<std::shared_ptr<const FrameRenderer>> got(kThreads);
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back(
        [&, t] { got[size_t(t)] = cache.Get(Sha256("s"), 7, RenderSettings(), OpenSource).value(); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(engine.imports, 1);
  for (const auto& frame : got) EXPECT_EQ(frame, got[0]);
}

TEST(FrameCache, BrokenScenesAreReadOnceAbsentOnesAgain) {
  FakeRenderer engine;
  absl::Status next = absl::InvalidArgumentError("accessor 3: nonsense");
  engine.before_import = [&] { return next; };
  FrameCache cache(engine, {});
  for (int i = 0; i < 5; ++i) {
    const auto frame = cache.Get(Sha256("broken"), i, RenderSettings(), OpenSource);
    EXPECT_EQ(frame.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(std::string(frame.status().message()).find("accessor 3"), std::string::npos);
  }
  EXPECT_EQ(engine.imports, 1);

  next = absl::UnavailableError("the coordinator is away");
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(cache.Get(Sha256("away"), 0, RenderSettings(), OpenSource).ok());
  }
  EXPECT_EQ(engine.imports, 4);
  next = absl::OkStatus();
  EXPECT_TRUE(cache.Get(Sha256("away"), 0, RenderSettings(), OpenSource).ok());
}

}  // namespace
}  // namespace shutterline::worker
