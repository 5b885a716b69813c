#include <algorithm>
#include <cmath>

#include "tests/scenes/keys.h"
#include "tests/scenes/random.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"

namespace shutterline::scenes {
namespace {

constexpr double kYfov = 20 * M_PI / 180;
constexpr int kColumns = 9, kRows = 5, kKinds = 3, kGreens = 3;
// Metres before the camera between which everything lies: the pan is 64 pixels at one and 29 at the other.
constexpr double kNearest = 12, kFarthest = 26.4;
constexpr float kCrown = 1.8f;  // The largest radius of a tree, metres.

struct Twig {
  V3f from, to;
};

/// A branch and what grows on it; the last two generations are where leaves hang.
void Grow(Random& random, Primitive& bark, std::vector<Twig>& twigs, const V3f& from, const V3f& direction,
          float length, float radius, int generation) {
  constexpr int kGenerations = 4, kForks = 4;
  const V3f to = from + direction * length;
  AddTube(bark, from, to, radius, radius * 0.6f, 5);
  if (generation >= kGenerations - 2) twigs.push_back({from, to});
  if (generation + 1 == kGenerations) return;
  V3f a, b;
  FrameOf(direction, a, b);
  for (int i = 0; i < kForks; ++i) {
    const double around = 2 * M_PI * (i + random.Uniform(-0.3, 0.3)) / kForks;
    const double away = random.Uniform(0.5, 0.95);
    const V3f side = a * float(std::cos(around)) + b * float(std::sin(around));
    const V3f fork = (direction * float(std::cos(away)) + side * float(std::sin(away))).normalized();
    Grow(random, bark, twigs, from + (to - from) * float(random.Uniform(0.55, 1)), fork,
         length * float(random.Uniform(0.55, 0.7)), radius * 0.5f, generation + 1);
  }
}

/// A tree of exactly `triangles` triangles: branches, and as many leaves as are then left.
Mesh MakeTree(Random& random, int kind, int triangles) {
  Mesh tree{"tree " + std::to_string(kind), std::vector<Primitive>(1 + kGreens)};
  tree.primitives[0].material = 0;
  for (int g = 0; g < kGreens; ++g) tree.primitives[size_t(1 + g)].material = 1 + kind * kGreens + g;
  std::vector<Twig> twigs;
  Grow(random, tree.primitives[0], twigs, V3f(0), V3f(0, 1, 0), 1.7f, 0.14f, 0);

  const int leaves = triangles - int(tree.primitives[0].triangles.size());
  for (int i = 0; i < leaves; ++i) {
    const Twig& twig = twigs[size_t(random.Index(int(twigs.size())))];
    const V3f place = twig.from + (twig.to - twig.from) * float(random.Uniform()) +
                      random.Direction() * float(random.Uniform(0, 0.18));
    // Every colour has a leaf, however few there are.
    Primitive& primitive = tree.primitives[size_t(1 + (i < kGreens ? i : random.Index(kGreens)))];
    const uint32_t first = uint32_t(primitive.positions.size());
    V3f a, b;
    FrameOf(random.Direction(), a, b);
    const float size = float(random.Uniform(0.05, 0.11));
    for (const V3f& corner : {place, place + (a * 0.7f + b) * size, place + (a - b * 0.4f) * (1.4f * size)}) {
      primitive.positions.push_back(corner);
    }
    primitive.triangles.push_back({first, first + 1, first + 2});
  }

  float radius = 0;
  for (Primitive& primitive : tree.primitives) {
    primitive.normals.clear();
    for (const V3f& p : primitive.positions) radius = std::max(radius, std::hypot(p.x, p.z));
  }
  for (Primitive& primitive : tree.primitives) {
    for (V3f& p : primitive.positions) p *= kCrown / radius;
  }
  return tree;
}

int AddGround(GlbScene& scene) {
  const std::array<uint32_t, 2> colors = {0x5c6b3a, 0x6b7a45};
  Mesh ground{"ground", std::vector<Primitive>(2)};
  for (size_t k = 0; k < 2; ++k) {
    Material material;
    material.name = "ground";
    material.color = Srgb(colors[k]);
    ground.primitives[k].material = scene.Add(material);
  }
  constexpr int kCells = 16;
  const float width = 18, depth = float(kFarthest - kNearest);
  for (int j = 0; j < kCells; ++j) {
    for (int i = 0; i < kCells; ++i) {
      const auto corner = [&](int x, int z) {
        return V3f((float(x) / kCells - 0.5f) * width, 0, -float(kNearest) - depth * float(z) / kCells);
      };
      AddPolygon(ground.primitives[size_t((i + j) % 2)],
                 {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  }
  for (Primitive& primitive : ground.primitives) primitive.normals.clear();
  return scene.Add(std::move(ground));
}

}  // namespace

/// A forest of 45 instances of three trees, many leaves deep, that the camera passes sideways: everything
/// moves by 29 to 64 pixels, the nearer the faster.
GlbScene MakeTrees(const SceneOptions& options) {
  const int each = options.triangles.value_or(270000) / (kColumns * kRows);
  const double motion = options.motion_pixels.value_or(64);
  const double metres = motion / PixelsPerMetre(kYfov, kNearest);

  GlbScene scene;
  const uint32_t colors[1 + kKinds * kGreens] = {0x4a3728, 0x2d6a4f, 0x40916c, 0x74a57f, 0x606c38,
                                                 0x8a9a3b, 0xa3b18a, 0xbc6c25, 0xdda15e, 0x9c6644};
  for (const uint32_t rgb : colors) {
    Material material;
    material.name = scene.materials.empty() ? "bark" : "leaf";
    material.color = Srgb(rgb);
    material.double_sided = true;
    scene.Add(material);
  }
  Random random(options.seed);
  for (int kind = 0; kind < kKinds; ++kind) scene.Add(MakeTree(random, kind, each));

  for (int row = 0; row < kRows; ++row) {
    const double first = kNearest + kCrown + 0.2, last = kFarthest - kCrown - 0.2;
    for (int column = 0; column < kColumns; ++column) {
      const double along = std::clamp((row + random.Uniform(-0.4, 0.4)) / (kRows - 1), 0.0, 1.0);
      const double depth = first + (last - first) * along;
      const double half_width = depth * std::tan(kYfov / 2) * 4 / 3 + 1;
      const double across = (column + random.Uniform(0.1, 0.9)) / kColumns * 2 - 1;
      Node tree;
      tree.name = "tree";
      tree.translation = V3f(float(across * half_width), 0, -float(depth));
      tree.rotation = Turn(V3f(0, 1, 0), random.Uniform(0, 360));
      tree.scale = float(random.Uniform(0.75, 1));
      tree.mesh = random.Index(kKinds);
      scene.Add(tree);
    }
  }
  Node ground;
  ground.name = "ground";
  ground.mesh = AddGround(scene);
  scene.Add(ground);

  const V3f eye(0, 1.6f, 0);
  const int camera = scene.Add(CameraNode(scene, {kYfov}, eye, eye - V3f(0, 0, 1)));
  if (motion > 0) scene.channels.push_back(SwingTranslation(camera, eye, V3f(float(metres), 0, 0)));
  return scene;
}

}  // namespace shutterline::scenes
