#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "common/image/image.h"
#include "common/job/render_settings.h"
#include "common/job/tile.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/scene.h"

/// Changes that must not change a picture, and how pictures are compared.
namespace shutterline::engine::invariance {

RenderSettings Small(int width = 70, int height = 45);

/// Whole frames through pose, hierarchy and integrator; frame 0.
Image Render(std::shared_ptr<const Scene> scene, const RenderSettings& settings, int threads = 1,
             int tile_size = kTileSize);
Image Render(std::shared_ptr<const FrameScene> frame, const RenderSettings& settings,
             int tile_size = kTileSize);

/// Over all channels; fails the test where a value is not finite.
double LargestDifference(const Image& a, const Image& b);

struct Difference {
  double largest = 0, rms = 0;
};
/// `a` at (x, y) against `b` at (x', y'): where b was mirrored left to right, or x and y exchanged.
Difference AgainstMirrored(const Image& a, const Image& b);
Difference AgainstExchanged(const Image& a, const Image& b);

/// Some triangles in view, moving or not, of several unlit colours.
struct Soup {
  std::vector<std::array<V3d, 3>> open, close;
  std::vector<V3f> colors;

  Soup Mirrored() const;
  Soup Exchanged() const;
  Soup Reversed() const { return {close, open, colors}; }
};
Soup RandomSoup(uint64_t seed, int count, double speed);
/// A primitive a triangle, in the order given.
std::shared_ptr<const FrameScene> Build(const Soup& soup, const std::vector<size_t>& order,
                                        const FrameView& view);
std::vector<size_t> InOrder(size_t count);

/// The scene with every node below a new root, and its camera, moved and scaled.
std::shared_ptr<const Scene> Moved(const Scene& scene, const V3d& offset, double scale);

/// The scene and a mesh of three triangles in front of everything, each with a vertex that holds `bad`.
std::shared_ptr<const Scene> WithBrokenMesh(const Scene& scene, float bad);

}  // namespace shutterline::engine::invariance
