#include "tests/stability/invariance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "tests/support/engine_frame.h"
#include "tests/support/frame_scene_builder.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/render/tile_integrator.h"

namespace shutterline::engine::invariance {
namespace {

/// The difference of `a` at (x, y) from `b` at where(x, y).
template <typename Where>
Difference Differences(const Image& a, const Image& b, const Where& where) {
  Difference result;
  double sum = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const auto [bx, by] = where(x, y);
      for (int c = 0; c < 4; ++c) {
        const double difference = std::abs(double(a.At(x, y)[c]) - double(b.At(bx, by)[c]));
        result.largest = std::max(result.largest, difference);
        sum += difference * difference;
      }
    }
  }
  result.rms = std::sqrt(sum / double(a.values().size()));
  return result;
}

template <typename Change>
Soup Changed(Soup soup, const Change& change) {
  for (auto* triangles : {&soup.open, &soup.close}) {
    for (auto& triangle : *triangles) {
      for (V3d& p : triangle) p = change(p);
    }
  }
  return soup;
}

}  // namespace

RenderSettings Small(int width, int height) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  return settings;
}

Image Render(std::shared_ptr<const Scene> scene, const RenderSettings& settings, int threads, int tile_size) {
  auto frame = RenderFrame(std::move(scene), 0, settings, {.threads = threads, .tile_size = tile_size});
  EXPECT_TRUE(frame.ok()) << frame.status();
  return frame.ok() ? std::move(frame->image) : Image();
}

Image Render(std::shared_ptr<const FrameScene> frame, const RenderSettings& settings, int tile_size) {
  auto integrator = MakeTileIntegrator(std::move(frame), 0, settings, 1);
  EXPECT_TRUE(integrator.ok()) << integrator.status();
  return RenderTiles(**integrator, settings.width, settings.height, tile_size, tile_size);
}

double LargestDifference(const Image& a, const Image& b) {
  EXPECT_EQ(a.values().size(), b.values().size());
  double largest = 0;
  for (size_t i = 0; i < a.values().size(); ++i) {
    EXPECT_TRUE(std::isfinite(a.values()[i]));
    largest = std::max(largest, double(std::abs(a.values()[i] - b.values()[i])));
  }
  return largest;
}

Difference AgainstMirrored(const Image& a, const Image& b) {
  return Differences(a, b, [&](int x, int y) { return std::pair(a.width() - 1 - x, y); });
}
Difference AgainstExchanged(const Image& a, const Image& b) {
  return Differences(a, b, [](int x, int y) { return std::pair(y, x); });
}

Soup Soup::Mirrored() const {
  return Changed(*this, [](const V3d& p) { return V3d(-p.x, p.y, p.z); });
}
Soup Soup::Exchanged() const {
  return Changed(*this, [](const V3d& p) { return V3d(-p.y, -p.x, p.z); });
}

Soup RandomSoup(uint64_t seed, int count, double speed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  Soup soup;
  for (int i = 0; i < count; ++i) {
    const V3d center(1.5 * unit(random), unit(random), -4 + 2 * unit(random));
    const V3d velocity(speed * unit(random), speed * unit(random), speed * unit(random));
    std::array<V3d, 3> open;
    std::array<V3d, 3> close;
    for (size_t k = 0; k < 3; ++k) {
      open[k] = center + V3d(unit(random), unit(random), unit(random)) * 0.4;
      close[k] = open[k] + velocity + V3d(unit(random), unit(random), unit(random)) * (speed / 4);
    }
    soup.open.push_back(open);
    soup.close.push_back(close);
    soup.colors.push_back(V3f(float(0.5 + 0.5 * unit(random)), float(0.5 + 0.5 * unit(random)), 0.25f));
  }
  return soup;
}

std::shared_ptr<const FrameScene> Build(const Soup& soup, const std::vector<size_t>& order,
                                        const FrameView& view) {
  FrameSceneBuilder builder(view);
  for (const size_t i : order)
    builder.AddViewTriangle(soup.open[i], soup.close[i], {.color = soup.colors[i]});
  return builder.Build();
}

std::vector<size_t> InOrder(size_t count) {
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t{0});
  return order;
}

std::shared_ptr<const Scene> Moved(const Scene& scene, const V3d& offset, double scale) {
  auto moved = std::make_shared<Scene>(scene);
  Node root;
  root.name = "moved";
  root.transform.translation = offset;
  root.transform.scale = V3d(scale, scale, scale);
  const int index = int(moved->nodes.size());
  for (const int child : moved->roots) {
    moved->nodes[size_t(child)].parent = index;
    root.children.push_back(child);
  }
  moved->nodes.push_back(root);
  moved->roots = {index};
  for (Camera& camera : moved->cameras) {
    camera.znear *= scale;
    camera.zfar *= scale;
  }
  return moved;
}

std::shared_ptr<const Scene> WithBrokenMesh(const Scene& scene, float bad) {
  auto broken = std::make_shared<Scene>(scene);
  MeshPrimitive primitive;
  primitive.positions = {V3f(0, 0, 0), V3f(bad, 1, 0), V3f(1, 0, bad), V3f(3, 3, 3)};
  primitive.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 2, 3}};
  primitive.material = int(broken->materials.size()) - 1;
  Mesh mesh;
  mesh.name = "broken";
  mesh.primitives = {primitive};
  Node node;
  node.name = "broken";
  node.mesh = int(broken->meshes.size());
  broken->meshes.push_back(mesh);
  broken->roots.push_back(int(broken->nodes.size()));
  broken->nodes.push_back(node);
  return broken;
}

}  // namespace shutterline::engine::invariance
