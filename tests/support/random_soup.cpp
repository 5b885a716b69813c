#include "tests/support/random_soup.h"

#include <array>
#include <random>
#include <vector>

#include "tests/support/frame_scene_builder.h"

namespace shutterline::engine {

std::shared_ptr<const FrameScene> RandomSoup(uint64_t seed, int triangles, bool curved) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  FrameSceneBuilder builder(PerspectiveView(32, 32));
  const auto somewhere = [&](double margin) { return -margin + unit(random) * (32 + 2 * margin); };
  for (int made = 0; made < triangles;) {
    const double size = std::exp2(unit(random) * 7 - 2);
    const double motion = unit(random) < 0.4 ? 0 : std::exp2(unit(random) * 8 - 2);
    const double distance = 0.5 + 9 * unit(random);
    const bool crosses = unit(random) < 0.1;
    const double x = somewhere(8);
    const double y = somewhere(8);
    const double dx = motion * (unit(random) - 0.5);
    const double dy = motion * (unit(random) - 0.5);
    // A strip of triangles over shared vertices.
    const int corners = 3 + int(random() % 6);
    const int points = motion == 0 ? 1 : curved && unit(random) < 0.5 ? 3 : 2;
    const FrameView view = PerspectiveView(32, 32);
    std::vector<RasterPoint> control;
    for (int i = 0; i < corners; ++i) {
      const double vx = x + size * (unit(random) - 0.5) + i * size / 4;
      const double vy = y + size * (unit(random) - 0.5);
      double vd = distance + 0.5 * (unit(random) - 0.5);
      for (int p = 0; p < points; ++p) {
        if (crosses && i == 0) vd = p == 0 ? 0.05 : -0.3;
        const double w = vd;
        const double bend = p == 1 && points == 3 ? 1 + unit(random) : p;
        control.push_back({(vx + bend * dx) * w, (vy + bend * dy) * w, view.znear, w});
      }
    }
    std::vector<std::array<uint32_t, 3>> mesh;
    for (uint32_t i = 2; i < uint32_t(corners); ++i) {
      mesh.push_back(i % 2 == 0 ? std::array{i - 2, i - 1, i} : std::array{i - 1, i - 2, i});
    }
    FlatLook look{.color = V3f(float(unit(random)), float(unit(random)), float(unit(random))),
                  .double_sided = unit(random) < 0.7};
    if (unit(random) < 0.3) {
      for (int i = 0; i < corners; ++i) {
        look.vertex_colors.push_back(V4f(float(unit(random)), float(unit(random)), float(unit(random)), 1));
      }
    }
    made += int(mesh.size());
    if (points < 3) {
      std::vector<RasterPoint> open;
      std::vector<RasterPoint> close;
      for (size_t i = 0; i < control.size(); i += size_t(points)) {
        open.push_back(control[i]);
        if (points == 2) close.push_back(control[i + 1]);
      }
      builder.AddMesh(open, close, mesh, look);
    } else {
      builder.AddCurvedMesh(control, 2, 1, mesh, look);
    }
  }
  return builder.Build();
}

}  // namespace shutterline::engine
