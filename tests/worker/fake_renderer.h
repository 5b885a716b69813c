#pragma once

#include <absl/synchronization/mutex.h>

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "worker/frames/frame_renderer.h"

namespace shutterline::worker {

/// An engine whose pixels are simple to foretell and that tests can slow down and break.
class FakeRenderer final : public FrameRendererFactory {
 public:
  /// What tile pixels hold: their own position, the frame and 1.
  static void Expected(const TileRect& rect, int frame, std::span<float> pixels) {
    size_t i = 0;
    for (int y = rect.y; y < rect.y + rect.height; ++y) {
      for (int x = rect.x; x < rect.x + rect.width; ++x, i += 4) {
        pixels[i] = float(x);
        pixels[i + 1] = float(y);
        pixels[i + 2] = float(frame);
        pixels[i + 3] = 1;
      }
    }
  }

  /// Called before each tile is rendered, from the thread that renders it; may block, fail or throw.
  std::function<absl::Status(const TileRect&, int frame)> before_tile;
  /// Called before each import; may fail.
  std::function<absl::Status()> before_import;
  std::atomic<int> imports = 0, frames = 0, tiles = 0;

  absl::StatusOr<std::shared_ptr<const engine::Scene>> Import(const engine::AssetSource& source) override {
    ++imports;
    if (before_import) {
      if (absl::Status status = before_import(); !status.ok()) return status;
    }
    const auto root = source.Read(source.RootName(), 1 << 20);
    if (!root.ok()) return root.status();
    auto scene = std::make_shared<engine::Scene>();
    scene->name = *root;
    return scene;
  }

  absl::StatusOr<std::shared_ptr<const FrameRenderer>> MakeFrame(std::shared_ptr<const engine::Scene>,
                                                                 int frame, const RenderSettings&,
                                                                 int) override {
    ++frames;
    return std::make_shared<const Frame>(*this, frame);
  }

 private:
  class Frame final : public FrameRenderer {
   public:
    Frame(FakeRenderer& owner, int frame) : owner_(owner), frame_(frame) {}
    absl::Status Render(const TileRect& rect, std::span<float> pixels,
                        engine::RenderStats& stats) const override {
      if (owner_.before_tile) {
        if (absl::Status status = owner_.before_tile(rect, frame_); !status.ok()) return status;
      }
      Expected(rect, frame_, pixels);
      ++owner_.tiles;
      ++stats.tiles;
      stats.lines += rect.Area();
      stats.resolve_seconds += 0.5;
      return absl::OkStatus();
    }

   private:
    FakeRenderer& owner_;
    const int frame_;
  };
};

}  // namespace shutterline::worker
