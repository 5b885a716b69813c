#include <cmath>

#include "tests/scenes/keys.h"
#include "tests/scenes/random.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"

namespace shutterline::scenes {

/// A tilted relief of small bumps, about 325 × 240 pixels large: with 100,000 triangles most are smaller
/// than a pixel. Each has one of six colours at random, so a picture's detail is as fine as its mesh.
GlbScene MakeStatic(const SceneOptions& options) {
  constexpr double kDepth = 10;
  const int triangles = options.triangles.value_or(100000);
  const double motion = options.motion_pixels.value_or(0);
  const int columns = int(std::sqrt(triangles / 1.6));
  const int rows = triangles / (2 * columns);
  const double metre = PixelsPerMetre(kDefaultYfov, kDepth);
  const double width = 325 / metre, height = 260 / metre;

  GlbScene scene;
  for (const uint32_t rgb : {0x264653u, 0x2a9d8fu, 0xe9c46au, 0xf4a261u, 0xe76f51u, 0xf1faeeu}) {
    Material material;
    material.name = "flat " + std::to_string(scene.materials.size());
    material.color = Srgb(rgb);
    material.double_sided = true;  // Bumps near the horizon turn their backs.
    scene.Add(material);
  }
  Random random(options.seed);
  const double phase_x = random.Uniform(0, 2 * M_PI), phase_y = random.Uniform(0, 2 * M_PI);
  Primitive whole;
  AddSurface(whole, columns, rows, [&](double u, double v) {
    const double bump = std::sin(23 * u + phase_x) * std::cos(19 * v + phase_y) + 0.4 * std::sin(61 * u * v);
    return V3f(float((u - 0.5) * width), float((v - 0.5) * height), float(0.06 * bump));
  });

  Mesh mesh{"relief", std::vector<Primitive>(scene.materials.size())};
  std::vector<std::vector<int64_t>> vertex_of(scene.materials.size(),
                                              std::vector<int64_t>(whole.positions.size(), -1));
  for (const auto& triangle : whole.triangles) {
    const size_t material = size_t(random.Index(int(scene.materials.size())));
    Primitive& primitive = mesh.primitives[material];
    primitive.material = int(material);
    std::array<uint32_t, 3> corners{};
    for (size_t k = 0; k < 3; ++k) {
      int64_t& vertex = vertex_of[material][triangle[k]];
      if (vertex < 0) {
        vertex = int64_t(primitive.positions.size());
        primitive.positions.push_back(whole.positions[triangle[k]]);
      }
      corners[k] = uint32_t(vertex);
    }
    primitive.triangles.push_back(corners);
  }
  std::erase_if(mesh.primitives, [](const Primitive& primitive) { return primitive.triangles.empty(); });

  Node relief;
  relief.name = "relief";
  relief.translation = V3f(0, 0, -float(kDepth));
  relief.rotation = Turn(V3f(0, 0, 1), 11) * Turn(V3f(1, 0, 0), -25);
  relief.mesh = scene.Add(std::move(mesh));
  const int node = scene.Add(relief);
  scene.Add(CameraNode(scene, {kDefaultYfov}, V3f(0), V3f(0, 0, -1)));
  if (motion > 0) {
    scene.channels.push_back(SwingTranslation(node, relief.translation, V3f(float(motion / metre), 0, 0)));
  }
  return scene;
}

}  // namespace shutterline::scenes
