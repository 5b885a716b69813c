#include <algorithm>
#include <cmath>

#include "tests/scenes/keys.h"
#include "tests/scenes/random.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"

namespace shutterline::scenes {
namespace {

constexpr double kYfov = 36 * M_PI / 180;

int AddMaterial(GlbScene& scene, const char* name, uint32_t rgb, bool double_sided = false) {
  Material material;
  material.name = name;
  material.color = Srgb(rgb);
  material.unlit = false;
  material.double_sided = double_sided;
  return scene.Add(material);
}

int AddNode(GlbScene& scene, const char* name, const V3f& place, std::vector<Primitive> primitives) {
  Node node;
  node.name = name;
  node.translation = place;
  node.mesh = scene.Add(Mesh{name, std::move(primitives)});
  return scene.Add(node);
}

/// A checkered table and, behind it, a wall whose colour fades from the horizon up.
void AddRoom(GlbScene& scene) {
  std::vector<Primitive> table(2);
  table[0].material = AddMaterial(scene, "light squares", 0xe8dcc4);
  table[1].material = AddMaterial(scene, "dark squares", 0x8d99ae);
  constexpr int kCells = 32;
  constexpr float kSide = 2.4f;
  for (int j = 0; j < kCells; ++j) {
    for (int i = 0; i < kCells; ++i) {
      const auto corner = [&](int x, int z) {
        return V3f((float(x) / kCells - 0.5f) * kSide, 0, (0.7f - float(z) / kCells) * kSide);
      };
      AddPolygon(table[size_t((i + j) % 2)],
                 {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  }
  AddNode(scene, "table", V3f(0), std::move(table));

  Primitive wall;
  Material paint;
  paint.name = "wall";
  wall.material = scene.Add(paint);  // Unlit, by vertex colour.
  AddSurface(wall, 1, 16, [](double u, double v) { return V3f(float(4 * (u - 0.5)), float(2 * v), -0.72f); });
  wall.normals.clear();
  const V3f low = Srgb(0xf6bd60), high = Srgb(0x1d3557);
  for (const V3f& p : wall.positions) {
    const float t = std::clamp(p.y / 0.75f, 0.0f, 1.0f);
    wall.colors.push_back(low * (1 - t) + high * t);
  }
  AddNode(scene, "wall", V3f(0), {std::move(wall)});
}

/// A sail from the hub outwards, twisted, with its front to +z.
void AddSail(Primitive& primitive, double degrees, float radius) {
  const Imath::Quatf turn = Turn(V3f(0, 0, 1), degrees);
  AddSurface(primitive, 6, 20, [&](double u, double v) {
    const double r = radius * (0.12 + 0.88 * v);
    const double chord = radius * (0.16 + 0.34 * std::sin(M_PI * (0.1 + 0.62 * v)));
    const double pitch = (50 - 38 * v) * M_PI / 180;
    const double across = (u - 0.25) * chord;
    return turn.rotateVector(
        V3f(float(across * std::cos(pitch)), float(r), -float(across * std::sin(pitch))));
  });
}

void AddWindmill(GlbScene& scene, const V3f& foot, float height, float radius, int sails, double start,
                 double degrees_per_shutter, const std::vector<uint32_t>& colors) {
  Primitive tower;
  tower.material = AddMaterial(scene, "tower", 0xf1faee);
  AddTube(tower, V3f(0), V3f(0, height, 0), radius * 0.2f, radius * 0.08f, 32);
  AddNode(scene, "tower", foot, {std::move(tower)});

  std::vector<Primitive> wheel;
  for (int i = 0; i < sails; ++i) {
    wheel.emplace_back().material =
        AddMaterial(scene, "sail", colors[size_t(i) % colors.size()], /*double_sided=*/true);
    AddSail(wheel.back(), -360.0 * i / sails, radius);
  }
  wheel.emplace_back().material = AddMaterial(scene, "hub", 0xe9c46a);
  AddSphere(wheel.back(), V3f(0, 0, radius * 0.02f), radius * 0.13f, 32, 16);
  const int node = AddNode(scene, "wheel", foot + V3f(0, height, radius * 0.22f), std::move(wheel));
  scene.channels.push_back(Spin(node, V3f(0, 0, 1), start, degrees_per_shutter));
}

/// Balls on a ring round `centre`, which turn about the vertical.
void AddCarousel(GlbScene& scene, const V3f& centre, float radius, int balls, double degrees_per_shutter) {
  std::vector<Primitive> ring(2);
  ring[0].material = AddMaterial(scene, "ball", 0xe63946);
  ring[1].material = AddMaterial(scene, "ball", 0xf1faee);
  for (int i = 0; i < balls; ++i) {
    const double angle = 2 * M_PI * i / balls;
    AddSphere(ring[size_t(i % 2)], V3f(float(std::cos(angle)), 0, float(std::sin(angle))) * radius, 0.017f,
              20, 10);
  }
  const int node = AddNode(scene, "carousel", centre, std::move(ring));
  scene.channels.push_back(Spin(node, V3f(0, 1, 0), 0, degrees_per_shutter));
}

/// A solid that falls, tumbles and bounces: keys every half frame, between which it moves on a line.
void AddFallingSolid(GlbScene& scene, Random& random, const V3f& start, float radius, int mesh) {
  constexpr double kGravity = 9.81, kBounce = 0.5;
  Node node;
  node.name = "solid";
  node.translation = start;
  node.scale = radius;
  node.mesh = mesh;
  const int index = scene.Add(node);

  Channel place{index, Path::kTranslation, {}, {}}, turn{index, Path::kRotation, {}, {}};
  const V3f axis = random.Direction();
  double angle = random.Uniform(0, 360), rate = random.Uniform(8, 24);  // Degrees a shutter.
  double y = start.y, speed = -random.Uniform(1.2, 2.6);                // Metres, metres a second.
  V3f drift = random.Direction() * 0.25f;
  for (int key = 0; key <= 2 * kAnimatedFrames; ++key) {
    const double time = key * kShutterSeconds;
    place.times.push_back(float(time));
    place.values.insert(place.values.end(),
                        {start.x + drift.x * float(time), float(y), start.z + drift.z * float(time)});
    const Imath::Quatf now = Turn(axis, angle);
    turn.times.push_back(float(time));
    turn.values.insert(turn.values.end(), {now.v.x, now.v.y, now.v.z, now.r});
    y += speed * kShutterSeconds - kGravity / 2 * kShutterSeconds * kShutterSeconds;
    speed -= kGravity * kShutterSeconds;
    angle += rate;
    if (y < radius && speed < 0) {
      y = radius + (radius - y) * kBounce;
      speed *= -kBounce;
      rate *= 0.6;
    }
  }
  scene.channels.push_back(std::move(place));
  scene.channels.push_back(std::move(turn));
}

void AddSolids(GlbScene& scene, uint64_t seed) {
  Random random(seed);
  const uint32_t colors[] = {0xe63946, 0xf4a261, 0xe9c46a, 0x2a9d8f, 0x457b9d, 0x9b5de5, 0xf15bb5, 0x00bbf9};
  constexpr int kShapes = 6;
  std::vector<int> meshes;
  for (const uint32_t rgb : colors) {
    const int material = AddMaterial(scene, "solid", rgb);
    Primitive solid;
    solid.material = material;
    switch (int(meshes.size()) % kShapes) {
      case 0:
        AddRegularSolid(solid, 20, 1);
        break;
      case 1:
        AddRegularSolid(solid, 6, 1);
        break;
      case 2:
        AddTorus(solid, V3f(0), 0.72f, 0.28f, 32, 16);
        break;
      case 3:
        AddRegularSolid(solid, 8, 1);
        break;
      case 4:
        AddRegularSolid(solid, 4, 1.2f);
        break;
      case 5:
        AddSphere(solid, V3f(0), 1, 24, 12);
        break;
    }
    meshes.push_back(scene.Add(Mesh{"solid", {std::move(solid)}}));
  }
  // Columns of falling solids left, right and behind; the upper ones come into view in later frames.
  constexpr int kSolids = 40;
  for (int i = 0; i < kSolids; ++i) {
    const double side = i % 2 == 0 ? -1 : 1;
    const V3f start(float(side * random.Uniform(0.21, 0.4)),
                    float(0.06 + 0.045 * i + random.Uniform(0, 0.03)), float(random.Uniform(-0.4, 0.14)));
    AddFallingSolid(scene, random, start, float(random.Uniform(0.018, 0.034)),
                    meshes[size_t(i) % meshes.size()]);
  }
}

}  // namespace

/// A toy windmill on a table, a smaller one before it, a ring of balls round them, and solids that rain
/// down: turning, tumbling and falling at once, in metres and speeds of real toys.
GlbScene MakeDemo(const SceneOptions& options) {
  GlbScene scene;
  AddRoom(scene);
  AddWindmill(scene, V3f(0, 0, -0.06f), 0.27f, 0.16f, 8, 12, -26,
              {0xe63946, 0xf4a261, 0xe9c46a, 0x8ac926, 0x2a9d8f, 0x1982c4, 0x6a4c93, 0xf15bb5});
  AddWindmill(scene, V3f(0.2f, 0, 0.16f), 0.11f, 0.062f, 5, 40, 33, {0x00bbf9, 0xf1faee});
  AddCarousel(scene, V3f(0, 0.018f, -0.03f), 0.21f, 16, 10);
  AddSolids(scene, options.seed);
  scene.Add(CameraNode(scene, {kYfov}, V3f(0, 0.3f, 0.86f), V3f(0, 0.19f, 0)));
  return scene;
}

}  // namespace shutterline::scenes
