#include <algorithm>
#include <cmath>

#include "tests/scenes/cloth.h"
#include "tests/scenes/keys.h"
#include "tests/scenes/light.h"
#include "tests/scenes/marble.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"
#include "tests/scenes/stone.h"
#include "tests/scenes/texcoords.h"

namespace shutterline::scenes {
namespace {

constexpr float kRadius = 1;       // Of the ball, metres.
constexpr double kHalfSide = 2.0;  // Of the cloth, metres.
constexpr int kBallColumns = 84, kBallRows = 64;
constexpr double kRim = 1.55;          // Metres from the axis; what `motion_pixels` refers to.
constexpr double kSett = 0.8;          // A repeat of the woven pattern, metres.
constexpr double kCheckers = 4;        // Pictures round the ball, of 4 × 4 squares.
constexpr float kFloorPicture = 4.4f;  // Metres, of 4 slabs.
const V3f kEye(0, 2.1f, 5.6f), kTarget(0, -0.2f, 0);

/// Where a point of the cloth lies, `p` being its place on the flat cloth: on the ball down to a bit above
/// its equator, from there in folds that widen.
V3f Drape(double px, double pz) {
  const double s = std::hypot(px, pz), around = s > 0 ? std::atan2(pz, px) : 0;
  const double radius = double(kRadius) * 1.012;
  const double leaves = 1.25 * radius;  // Length of arc at which the cloth leaves the ball.
  double out, y;
  if (s < leaves) {
    out = radius * std::sin(s / radius);
    y = radius * std::cos(s / radius);
  } else {
    const double below = s - leaves, fold = below / (0.45 + below);
    out = radius * std::sin(leaves / radius) + 0.2 * below +
          fold * (0.2 * std::cos(8 * around + 0.7) + 0.07 * std::cos(13 * around));
    y = radius * std::cos(leaves / radius) - 0.93 * below;
  }
  return V3f(float(out * std::cos(around)), float(y), float(out * std::sin(around)));
}

/// Tartan as a colour a vertex: stripes of both directions, mixed.
V3f TartanColor(double px, double pz) {
  const V3f red = Srgb(0xb5172f), navy = Srgb(0x14213d), gold = Srgb(0xfcbf49), cream = Srgb(0xf4ead5);
  const auto thread = [&](double p) {
    const double x = p * 2.5 - std::floor(p * 2.5);
    return x < 0.42 ? red : x < 0.48 ? gold : x < 0.8 ? navy : x < 0.84 ? cream : navy;
  };
  return (thread(px) + thread(pz)) * 0.5f;
}

/// Numbers of the scene's materials.
struct Materials {
  int cloth, ball, floor;
};

Materials AddPlainMaterial(GlbScene& scene) {
  Material material;
  material.name = "by vertex colour";
  material.double_sided = true;
  const int all = scene.Add(material);
  return {all, all, all};
}

/// A woollen tartan on a ball of marble checkers, over slabs of stone.
Materials AddTexturedMaterials(GlbScene& scene) {
  const SurfaceImages tartan = AddImages(scene, "tartan", Tartan(512, 64, 1));
  const SurfaceImages checkers =
      AddImages(scene, "checkers", MarbleChecker(512, WhiteMarble(), GreenMarble(), 4, 2));
  const SurfaceImages slabs = AddImages(scene, "slabs", FloorTiles(1024, Travertine(), 4, 3));
  return {AddSurfaceMaterial(scene, "tartan", tartan, /*double_sided=*/true),
          AddSurfaceMaterial(scene, "marble", checkers),
          AddSurfaceMaterial(scene, "slabs", slabs, /*double_sided=*/false, V3f(0.5f))};
}

}  // namespace

/// A cloth over a ball, both of which turn by an eighth of a turn while the shutter is open, on a floor that
/// stands still: every vertex of 92,000 small triangles moves on an arc of a circle. Chance is not in
/// it.
GlbScene MakeClothBall(const SceneOptions& options) {
  const double rim_pixels =
      kRim * PixelsPerMetre(kDefaultYfov, double((kTarget - kEye).length()) - 0.5 * kRim);
  const double degrees = options.motion_pixels ? *options.motion_pixels / rim_pixels * 180 / M_PI : 45.0;
  const int cells = options.tessellation.value_or(196);

  GlbScene scene;
  const Materials materials = options.textured ? AddTexturedMaterials(scene) : AddPlainMaterial(scene);
  Primitive cloth;
  cloth.material = materials.cloth;
  const auto flat = [&](double u) { return (2 * u - 1) * kHalfSide; };
  AddSurface(cloth, cells, cells, [&](double u, double v) { return Drape(flat(u), flat(1 - v)); });
  Primitive ball;
  ball.material = materials.ball;
  AddSphere(ball, V3f(0), kRadius, kBallColumns, kBallRows);
  if (options.textured) {
    MapSurface(cloth, cells, cells,
               [&](double u, double v) { return V2f(float(flat(u) / kSett), float(flat(1 - v) / kSett)); });
    MapSurface(ball, kBallColumns, kBallRows,
               [](double u, double v) { return V2f(float(kCheckers * u), float(kCheckers / 2 * (1 - v))); });
  } else {
    for (size_t i = 0; i < cloth.positions.size(); ++i) {
      const auto row = int(i) / (cells + 1), column = int(i) % (cells + 1);
      const V3f color = TartanColor(flat(double(column) / cells), flat(1 - double(row) / cells));
      cloth.colors.push_back(BakedColor(color, cloth.normals[i]));
    }
    cloth.normals.clear();
    BakeLight(ball, Srgb(0x2a9d8f));
  }
  Node both;
  both.name = "cloth and ball";
  both.mesh = scene.Add(Mesh{"cloth and ball", {std::move(cloth), std::move(ball)}});
  const int node = scene.Add(both);

  Primitive floor;
  floor.material = materials.floor;
  AddSurface(floor, 48, 48, [](double u, double v) {
    return V3f(float(160 * (u - 0.5)), -1.75f, float(160 * (0.5 - v) - 70));
  });
  const V3f stone = options.textured ? V3f(1) : Srgb(0xb8b8c0);
  for (const V3f& p : floor.positions) {
    const float away2 = p.x * p.x + p.z * p.z;
    floor.colors.push_back(stone * ((1 - 0.6f * std::exp(-0.35f * away2)) / (1 + 0.008f * away2)));
  }
  if (options.textured) {
    MapByFacing(floor, 1 / kFloorPicture);
  } else {
    floor.normals.clear();
  }
  Node under;
  under.name = "floor";
  under.mesh = scene.Add(Mesh{"floor", {std::move(floor)}});
  scene.Add(under);

  scene.Add(CameraNode(scene, {kDefaultYfov}, kEye, kTarget));
  if (degrees > 0) scene.channels.push_back(Spin(node, V3f(0, 1, 0), 20, degrees));
  return scene;
}

}  // namespace shutterline::scenes
