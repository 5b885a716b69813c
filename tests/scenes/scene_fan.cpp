#include <cmath>

#include "tests/scenes/keys.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"

namespace shutterline::scenes {
namespace {

constexpr float kTip = 2.6f, kRoot = 0.3f;  // Metres.
constexpr double kDepth = 10;

/// A twisted blade along +y, steeper at its root.
void AddBlade(Primitive& primitive, double degrees) {
  const Imath::Quatf turn = Turn(V3f(0, 0, 1), degrees);
  AddSurface(primitive, 6, 24, [&](double u, double v) {
    const double radius = kRoot + (kTip - kRoot) * v;
    const double chord = 0.5 + 0.9 * std::sin(M_PI * (0.15 + 0.75 * v));
    const double pitch = (55 - 35 * v) * M_PI / 180;
    const double across = (u - 0.5) * chord;
    return turn.rotateVector(
        V3f(float(across * std::cos(pitch)), float(radius), float(across * std::sin(pitch))));
  });
}

int AddMaterial(GlbScene& scene, const char* name, uint32_t rgb) {
  Material material;
  material.name = name;
  material.color = Srgb(rgb);
  material.double_sided = true;
  return scene.Add(material);
}

void AddMeshNode(GlbScene& scene, const char* name, std::vector<Primitive> primitives) {
  for (Primitive& primitive : primitives) primitive.normals.clear();  // Unlit: nobody needs them.
  Node node;
  node.name = name;
  node.translation = V3f(0, 0, -float(kDepth));
  node.mesh = scene.Add(Mesh{name, std::move(primitives)});
  scene.Add(node);
}

}  // namespace

/// Fast rotation: five blades round a hub, in a still ring, behind a guard of thin still bars. Neither the
/// seed nor chance is in it.
GlbScene MakeFan(const SceneOptions& options) {
  constexpr int kBlades = 5;
  const double tip_pixels = kTip * PixelsPerMetre(kDefaultYfov, kDepth);
  const double degrees = options.motion_pixels ? *options.motion_pixels / tip_pixels * 180 / M_PI : 30.0;

  GlbScene scene;
  std::vector<Primitive> rotor;
  const uint32_t colors[kBlades] = {0xe63946, 0xf1faee, 0xa8dadc, 0x457b9d, 0xffb703};
  for (int i = 0; i < kBlades; ++i) {
    rotor.emplace_back().material = AddMaterial(scene, "blade", colors[i]);
    AddBlade(rotor.back(), 360.0 * i / kBlades);
  }
  rotor.emplace_back().material = AddMaterial(scene, "hub", 0x333344);
  AddSphere(rotor.back(), V3f(0), 0.45f, 24, 12);
  AddMeshNode(scene, "rotor", std::move(rotor));

  Primitive ring, guard, stand;
  ring.material = AddMaterial(scene, "ring", 0x6d6875);
  AddTorus(ring, V3f(0), 2.95f, 0.14f, 72, 12);
  guard.material = AddMaterial(scene, "guard", 0xb5b5b5);
  for (int i = 0; i < 24; ++i) {
    const double angle = 2 * M_PI * (i + 0.3) / 24;
    const V3f out(float(std::cos(angle)), float(std::sin(angle)), 0);
    AddTube(guard, out * 0.3f + V3f(0, 0, 0.9f), out * 2.9f + V3f(0, 0, 0.6f), 0.012f, 0.012f, 6);
  }
  for (const float radius : {0.3f, 1.2f, 2.1f}) AddTorus(guard, V3f(0, 0, 0.8f), radius, 0.015f, 72, 6);
  stand.material = AddMaterial(scene, "stand", 0x2b2d42);
  AddTube(stand, V3f(0, -3.05f, 0), V3f(0, -3.6f, 0), 0.15f, 0.25f, 24);
  AddBox(stand, V3f(-1.4f, -3.75f, -0.6f), V3f(1.4f, -3.55f, 0.6f));
  AddMeshNode(scene, "housing", {std::move(ring), std::move(guard), std::move(stand)});

  scene.Add(CameraNode(scene, {kDefaultYfov}, V3f(0), V3f(0, 0, -1)));
  if (degrees > 0) scene.channels.push_back(Spin(0, V3f(0, 0, 1), 10, degrees));
  return scene;
}

}  // namespace shutterline::scenes
