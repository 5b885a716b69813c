#include <cmath>

#include "tests/scenes/keys.h"
#include "tests/scenes/random.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"

namespace shutterline::scenes {

/// A square that faces the camera and pans sideways, so every vertex moves by the same number of pixels.
/// It is turned by 15 degrees, because patterns of lines favour edges along the axes.
GlbScene MakePlane(const SceneOptions& options) {
  constexpr float kSide = 5.6f;
  constexpr double kDepth = 10;
  const int cells = options.tessellation.value_or(16);
  const double metres = options.motion_pixels.value_or(60) / PixelsPerMetre(kDefaultYfov, kDepth);

  GlbScene scene;
  for (const uint32_t rgb : {0xd1495bu, 0xf4f1deu, 0xedae49u, 0x30638eu, 0x003d5bu, 0x66a182u}) {
    Material material;
    material.name = "flat " + std::to_string(scene.materials.size());
    material.color = Srgb(rgb);
    scene.Add(material);
  }

  // Even and odd cells of the checker draw from different halves of the palette, so neighbours differ.
  Random random(options.seed);
  const int half = int(scene.materials.size()) / 2;
  Mesh mesh{"plane", std::vector<Primitive>(scene.materials.size())};
  std::vector<std::vector<int64_t>> vertex_of(
      scene.materials.size(), std::vector<int64_t>(size_t(cells + 1) * size_t(cells + 1), -1));
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int material = (i + j) % 2 * half + random.Index(half);
      Primitive& primitive = mesh.primitives[size_t(material)];
      primitive.material = material;
      const auto corner = [&](int x, int y) {
        int64_t& vertex = vertex_of[size_t(material)][size_t(y) * size_t(cells + 1) + size_t(x)];
        if (vertex < 0) {
          vertex = int64_t(primitive.positions.size());
          primitive.positions.emplace_back((float(x) / float(cells) - 0.5f) * kSide,
                                           (float(y) / float(cells) - 0.5f) * kSide, 0.0f);
        }
        return uint32_t(vertex);
      };
      const uint32_t a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
      primitive.triangles.push_back({a, b, c});
      primitive.triangles.push_back({a, c, d});
    }
  }
  std::erase_if(mesh.primitives, [](const Primitive& primitive) { return primitive.triangles.empty(); });

  Node plane;
  plane.name = "plane";
  plane.translation = V3f(0, 0, -float(kDepth));
  plane.rotation = Turn(V3f(0, 0, 1), 15);
  plane.mesh = scene.Add(std::move(mesh));
  const int node = scene.Add(plane);
  scene.Add(CameraNode(scene, {kDefaultYfov}, V3f(0), V3f(0, 0, -1)));
  scene.channels.push_back(SwingTranslation(node, plane.translation, V3f(float(metres), 0, 0)));
  return scene;
}

}  // namespace shutterline::scenes
