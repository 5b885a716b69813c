#include <algorithm>
#include <cmath>

#include "tests/scenes/keys.h"
#include "tests/scenes/light.h"
#include "tests/scenes/random.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"
#include "tests/scenes/skin.h"
#include "tests/scenes/texcoords.h"

namespace shutterline::scenes {
namespace {

constexpr double kDepth = 10;
constexpr float kScale = 1.45f;
constexpr int kFragments = 160;
constexpr double kHide = 1.4;     // Of a picture of the skin, the side, metres of the body.
constexpr double kCell = 0.0185;  // About the side of a cell of the surface, metres, at the default count.

/// A limb from `a` to `b` that swells in the middle, with a grain across it, closed at both ends.
struct Limb {
  V3f a, b;
  double radius_a, radius_b, swell, grain;
};

const Limb kLimbs[] = {
    {{0, -0.75f, 0}, {0, 0.75f, 0.05f}, 0.5, 0.36, 0.22, 0.035},            // Body, armoured.
    {{0, 0.8f, 0.08f}, {0, 1.2f, 0.38f}, 0.26, 0.23, 0.08, 0.012},          // Head.
    {{0, 1.16f, 0.42f}, {0, 1.02f, 0.85f}, 0.17, 0.07, 0.02, 0.008},        // Snout.
    {{-0.14f, 1.28f, 0.12f}, {-0.3f, 1.72f, 0.0f}, 0.07, 0.02, 0.07, 0.0},  // Ears.
    {{0.14f, 1.28f, 0.12f}, {0.3f, 1.72f, 0.0f}, 0.07, 0.02, 0.07, 0.0},
    {{-0.4f, 0.5f, 0.05f}, {-1.05f, 0.72f, 0.28f}, 0.2, 0.14, 0.05, 0.015},  // Arms.
    {{-1.05f, 0.72f, 0.28f}, {-1.3f, 1.25f, 0.5f}, 0.14, 0.1, 0.03, 0.012},
    {{0.4f, 0.5f, 0.05f}, {1.0f, 0.35f, 0.4f}, 0.2, 0.14, 0.05, 0.015},
    {{1.0f, 0.35f, 0.4f}, {1.25f, 0.8f, 0.75f}, 0.14, 0.1, 0.03, 0.012},
    {{-0.28f, -0.8f, 0.05f}, {-0.55f, -1.35f, 0.3f}, 0.28, 0.19, 0.06, 0.015},  // Legs.
    {{-0.55f, -1.35f, 0.3f}, {-0.6f, -1.95f, 0.05f}, 0.18, 0.12, 0.04, 0.012},
    {{-0.6f, -1.98f, -0.02f}, {-0.68f, -2.0f, 0.42f}, 0.13, 0.1, 0.02, 0.008},
    {{0.28f, -0.8f, 0.05f}, {0.6f, -1.35f, 0.2f}, 0.28, 0.19, 0.06, 0.015},
    {{0.6f, -1.35f, 0.2f}, {0.62f, -1.95f, -0.05f}, 0.18, 0.12, 0.04, 0.012},
    {{0.62f, -1.98f, -0.1f}, {0.75f, -2.0f, 0.35f}, 0.13, 0.1, 0.02, 0.008},
    {{0, -0.7f, -0.35f}, {0.45f, -1.5f, -1.1f}, 0.22, 0.05, 0.04, 0.02},  // Tail.
};

/// Cells round a limb and along it.
struct Cells {
  int around, along;
};

double GirthOf(const Limb& limb) {
  return 2 * M_PI * (std::max(limb.radius_a, limb.radius_b) + limb.swell);
}

double LengthOf(const Limb& limb) {
  return double((limb.b - limb.a).length()) + limb.radius_a + limb.radius_b;
}

Cells CellsOf(const Limb& limb, double cell) {
  return {std::max(4, int(std::lround(GirthOf(limb) / cell))),
          std::max(4, int(std::lround(LengthOf(limb) / cell)))};
}

void AddLimb(Primitive& body, const Limb& limb, double cell) {
  const V3f axis = (limb.b - limb.a).normalized();
  const float length = (limb.b - limb.a).length();
  V3f x, y;
  FrameOf(axis, x, y);
  const Cells cells = CellsOf(limb, cell);
  AddSurface(body, cells.around, cells.along, [&](double u, double v) {
    const double angle = 2 * M_PI * u, polar = M_PI * v;  // Along by angle, which rounds the ends.
    const double along = 0.5 - 0.5 * std::cos(polar);
    const double taper = limb.radius_a + (limb.radius_b - limb.radius_a) * along;
    const double bulge = taper + limb.swell * std::sin(M_PI * along);
    const double grain =
        limb.grain * (std::sin(38 * along * double(length)) + 0.6 * std::sin(9 * angle + 11 * along));
    const double radius = std::pow(std::sin(polar), 0.55) * (bulge + grain * std::sin(polar));
    const double place = -taper * 0.7 * std::cos(polar) + double(length) * along;
    const V3f out = x * float(std::cos(angle)) + y * float(std::sin(angle));
    return limb.a + axis * float(place) + out * float(radius);
  });
  // The skin goes round a limb a whole number of times, and is as long as the limb.
  const double around = std::max(1.0, std::round(GirthOf(limb) / kHide)), along = LengthOf(limb) / kHide;
  MapSurface(body, cells.around, cells.along,
             [&](double u, double v) { return V2f(float(around * u), float(along * (1 - v))); });
}

/// A studio: a floor that bends up into a wall, lighter where the light falls.
int AddStudio(GlbScene& scene, double floor) {
  Primitive studio;
  AddSurface(studio, 24, 24, [&](double u, double v) {
    const double along = v * 26, bend = 2.5;  // Metres from the camera along floor, bend and wall.
    const double angle = std::clamp((along - 9) / bend, 0.0, M_PI / 2);
    const double flat = std::min(along, 9.0), wall = std::max(0.0, along - 9 - bend * M_PI / 2);
    return V3f(float(32 * (u - 0.5)), float(floor + bend * (1 - std::cos(angle)) + wall),
               -float(kDepth - 5 + flat + bend * std::sin(angle)));
  });
  const V3f paper = Srgb(0x6f8fa6);
  for (const V3f& p : studio.positions) {
    const V3f from_light = p - V3f(-1.5f, float(floor), -float(kDepth) - 1);
    studio.colors.push_back(paper * (0.25f + 0.75f / (1 + 0.05f * from_light.length2())));
  }
  studio.normals.clear();
  Node node;
  node.name = "studio";
  node.mesh = scene.Add(Mesh{"studio", {std::move(studio)}});
  return scene.Add(node);
}

}  // namespace

/// An armadillo, of clay or with a hide of horny plates, that bursts: its skin in pieces, each of which flies
/// and turns on its own, the faster the nearer it is to where it was hit. Nearly all triangles are smaller
/// than a pixel.
GlbScene MakeArmadillo(const SceneOptions& options) {
  const double motion = options.motion_pixels.value_or(50);
  const double wanted = options.triangles.value_or(88120) - 2 * 24 * 24;
  double cell = kCell;
  for (int step = 0; step < 20; ++step) {  // Until the cells number what was asked for, as near as they go.
    double count = 0;
    for (const Limb& limb : kLimbs) count += 2.0 * CellsOf(limb, cell).around * CellsOf(limb, cell).along;
    cell *= std::sqrt(count / wanted);
  }
  Primitive body;
  for (const Limb& limb : kLimbs) AddLimb(body, limb, cell);

  // Where it was hit, and the seeds of the pieces: a triangle goes with the nearest.
  Random random(options.seed);
  const V3f hit(0.3f, 0.3f, 0.5f);
  std::vector<V3f> seeds;
  for (int i = 0; i < kFragments; ++i) {
    seeds.push_back(body.positions[size_t(random.Index(int(body.positions.size())))]);
  }
  std::vector<Primitive> fragments(kFragments);
  std::vector<std::vector<int64_t>> vertex_of(kFragments, std::vector<int64_t>(body.positions.size(), -1));
  const V3f clay = Srgb(0xc98b62), flesh = Srgb(0xe0b089);
  for (const auto& triangle : body.triangles) {
    const V3f centre =
        (body.positions[triangle[0]] + body.positions[triangle[1]] + body.positions[triangle[2]]) / 3.0f;
    const auto nearest = std::min_element(seeds.begin(), seeds.end(), [&](const V3f& a, const V3f& b) {
      return (a - centre).length2() < (b - centre).length2();
    });
    const size_t number = size_t(nearest - seeds.begin());
    Primitive& fragment = fragments[number];
    std::array<uint32_t, 3> corners{};
    for (size_t k = 0; k < 3; ++k) {
      int64_t& vertex = vertex_of[number][triangle[k]];
      if (vertex < 0) {
        vertex = int64_t(fragment.positions.size());
        const V3f& p = body.positions[triangle[k]];
        fragment.positions.push_back(p - *nearest);
        if (options.textured) {
          fragment.normals.push_back(body.normals[triangle[k]]);
          fragment.texcoords.push_back(body.texcoords[triangle[k]]);
        } else {
          const float band = 0.5f + 0.5f * std::sin(14 * p.y + 3 * p.x);
          fragment.colors.push_back(BakedColor(clay * (1 - band) + flesh * band, body.normals[triangle[k]]));
        }
      }
      corners[k] = uint32_t(vertex);
    }
    fragment.triangles.push_back(corners);
  }

  GlbScene scene;
  Material material;
  material.name = "clay";
  material.double_sided = true;
  scene.Add(material);
  int skin = 0;
  if (options.textured) {
    const SurfaceImages hide = AddImages(scene, "hide", Hide(512, 24, 1));
    skin = AddSurfaceMaterial(scene, "hide", hide, /*double_sided=*/true);
  }
  AddStudio(scene, 0.3 - 2.15 * double(kScale));
  const Imath::Quatf pose = Turn(V3f(0, 1, 0), 28);
  const V3f place(0.1f, 0.3f, -float(kDepth));
  for (size_t i = 0; i < fragments.size(); ++i) {
    if (fragments[i].triangles.empty()) continue;
    // How much of the blast reaches it, and where to it flies.
    const V3f from = seeds[i] - hit;
    const double reach = std::exp(-1.5 * double(from.length2()));
    const V3f flight = pose.rotateVector((from.normalized() + random.Direction() * 0.35f).normalized());
    const double pixels = motion * (0.06 + 0.94 * reach) * random.Uniform(0.5, 0.9);
    const V3f way = flight * float(pixels / PixelsPerMetre(kDefaultYfov, kDepth));
    const double degrees = 18 * reach * random.Uniform(0.3, 1) * motion / 50;
    const V3f axis = random.Direction();
    Node node;
    node.name = "piece";
    fragments[i].material = skin;
    node.mesh = scene.Add(Mesh{"piece", {std::move(fragments[i])}});
    node.translation = place + pose.rotateVector(seeds[i]) * kScale + flight * float(1.3 * reach);
    node.rotation = Turn(axis, 2 * degrees) * pose;
    node.scale = kScale;
    const int index = scene.Add(node);
    if (motion > 0) {
      scene.channels.push_back(SwingTranslation(index, node.translation, way));
      scene.channels.push_back(SwingRotation(index, axis, degrees, node.rotation));
    }
  }
  scene.Add(CameraNode(scene, {kDefaultYfov}, V3f(0), V3f(0, 0, -1)));
  return scene;
}

}  // namespace shutterline::scenes
