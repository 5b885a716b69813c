#include <cmath>

#include "tests/scenes/keys.h"
#include "tests/scenes/random.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"

namespace shutterline::scenes {

/// Single triangles through all depths, each vertex on a line of its own: nothing but visibility between
/// independent movers. One mesh with a morph target, whose weight swings, moves them all.
GlbScene MakeDebris(const SceneOptions& options) {
  constexpr double kNear = 7, kFar = 20;  // Metres.
  const int count = options.triangles.value_or(5000);
  const double fastest = options.motion_pixels.value_or(60);

  GlbScene scene;
  Material material;
  material.name = "flat, by vertex colour";
  material.double_sided = true;
  Primitive primitive;
  primitive.material = scene.Add(material);

  Random random(options.seed);
  for (int i = 0; i < count; ++i) {
    // Uniform in the camera's view, a little beyond its border.
    const double depth = std::cbrt(random.Uniform(std::pow(kNear, 3), std::pow(kFar, 3)));
    const double half_height = 1.1 * depth * std::tan(kDefaultYfov / 2), half_width = half_height * 4 / 3;
    const V3f centre(float(random.Uniform(-half_width, half_width)),
                     float(random.Uniform(-half_height, half_height)), -float(depth));
    const double size = random.Uniform(0.1, 0.4);
    // The way over a leg, in metres at this depth; vertices deviate a little from their triangle's, which
    // so turns and stretches as it flies.
    const double pixels = fastest * random.Uniform(0.1, 0.9);
    const double way = kLegShutters * pixels / PixelsPerMetre(kDefaultYfov, depth);
    const V3f flight = random.Direction() * float(way);
    const V3f color(float(random.Uniform(0.05, 1)), float(random.Uniform(0.05, 1)),
                    float(random.Uniform(0.05, 1)));
    const uint32_t first = uint32_t(primitive.positions.size());
    for (int corner = 0; corner < 3; ++corner) {
      const V3f offset = flight + random.Direction() * float(0.1 * way);
      // Half-way through a leg, the triangle is where it was drawn.
      primitive.positions.push_back(centre + random.Direction() * float(size) - flight * 0.5f);
      primitive.morph_offsets.push_back(offset);
      primitive.colors.push_back(color);
    }
    primitive.triangles.push_back({first, first + 1, first + 2});
  }

  Node debris;
  debris.name = "debris";
  debris.mesh = scene.Add(Mesh{"debris", {std::move(primitive)}});
  const int node = scene.Add(debris);
  scene.Add(CameraNode(scene, {kDefaultYfov}, V3f(0), V3f(0, 0, -1)));
  scene.channels.push_back(SwingWeight(node));
  return scene;
}

}  // namespace shutterline::scenes
