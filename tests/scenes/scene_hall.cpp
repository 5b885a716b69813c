#include <algorithm>
#include <cmath>

#include "tests/scenes/cloth.h"
#include "tests/scenes/keys.h"
#include "tests/scenes/marble.h"
#include "tests/scenes/noise.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"
#include "tests/scenes/stone.h"
#include "tests/scenes/texcoords.h"

namespace shutterline::scenes {
namespace {

constexpr double kYfov = 58 * M_PI / 180;
constexpr float kHalfLength = 14, kHalfWidth = 5.2f, kAisle = 2.9f, kHeight = 7.5f;  // Metres.
constexpr float kSpring = 2.7f;  // Where the arches begin.
constexpr int kBays = 8;         // Of 3.5 metres each.
constexpr float kBay = 2 * kHalfLength / kBays;

// Sides of pictures, metres.
constexpr float kPlaster = 4, kBlocks = 2.4f, kMarble = 1.6f, kBanner = 1.9f;
constexpr int kSlabs = 4;  // Floor tiles along a side of their picture.

int AddMaterial(GlbScene& scene, const char* name, uint32_t rgb, bool double_sided = false) {
  Material material;
  material.name = name;
  material.color = Srgb(rgb);
  material.unlit = false;
  material.double_sided = double_sided;
  return scene.Add(material);
}

/// Numbers of the scene's materials.
struct Materials {
  int walls, light_tiles, dark_tiles, gallery, columns, arches, vase, cloths[3];
};

Materials AddPlainMaterials(GlbScene& scene) {
  const int walls = AddMaterial(scene, "plaster", 0xd8c3a0, true);
  const int light = AddMaterial(scene, "light tiles", 0xcfc4b0);
  const int dark = AddMaterial(scene, "dark tiles", 0x8c6f5a);
  const int gallery = AddMaterial(scene, "stone", 0xc9b28f),
            columns = AddMaterial(scene, "columns", 0xe3d2b4);
  const int vase = AddMaterial(scene, "clay", 0xb5603c, true);
  return {walls,
          light,
          dark,
          gallery,
          columns,
          columns,
          vase,
          {AddMaterial(scene, "red cloth", 0xa4161a, true), AddMaterial(scene, "green cloth", 0x2d6a4f, true),
           AddMaterial(scene, "blue cloth", 0x1d4e89, true)}};
}

/// Plastered walls, a floor of two stones, arches of sandstone blocks on marble columns, woven hangings.
Materials AddTexturedMaterials(GlbScene& scene) {
  const auto add = [&](const char* name, const SurfaceMap& map, bool double_sided = false) {
    return AddSurfaceMaterial(scene, name, AddImages(scene, name, map), double_sided);
  };
  const int walls = add("plaster", Plaster(512, SrgbCode(0xf0dcb4), 1), true);
  const int light = add("travertine", FloorTiles(1024, Travertine(), kSlabs, 2));
  const int dark = add("red limestone", FloorTiles(1024, RedLimestone(), kSlabs, 3));
  const int blocks = add("sandstone", Masonry(512, Sandstone(), 6, 4));
  const int marble = add("marble", Marble(512, CreamMarble(), 5));
  const int clay = add("terracotta", Rock(512, Terracotta(), 6), true);
  const auto hanging = [&](const char* name, uint32_t ground, uint32_t figure, uint32_t seed) {
    return add(name, Banner(512, 96, SrgbCode(ground), SrgbCode(figure), seed), true);
  };
  return {walls,
          light,
          dark,
          blocks,
          marble,
          blocks,
          clay,
          {hanging("red cloth", 0xb3202a, 0xf0c65a, 7), hanging("green cloth", 0x2c7a55, 0xe9dfc3, 8),
           hanging("blue cloth", 0x23599c, 0xe3c98a, 9)}};
}

/// Light that falls through the open roof into the nave: less below, behind the columns and in corners.
V3f DaylightAt(const V3f& p, const V3f& normal) {
  const float open = std::clamp(1.15f - std::abs(p.x) / kHalfWidth * 0.75f, 0.35f, 1.0f);
  const float up = 0.6f + 0.4f * std::clamp(p.y / kHeight, 0.0f, 1.0f);
  const float sun = std::max(0.0f, normal.dot(V3f(-0.5f, 0.8f, 0.33f)));
  const V3f warm(1.0f, 0.93f, 0.82f), cool(0.75f, 0.85f, 1.0f);
  return cool * (0.7f * open * up) + warm * (0.6f * open * (0.4f + 0.6f * sun));
}

void AddNode(GlbScene& scene, const char* name, int material, Primitive primitive) {
  primitive.material = material;
  // What bounces from bright textured walls fills the shade.
  const bool textured = scene.materials[size_t(material)].color_texture.image >= 0;
  for (size_t i = 0; i < primitive.positions.size(); ++i) {
    const V3f light = DaylightAt(primitive.positions[i], primitive.normals[i]);
    primitive.colors.push_back(textured ? V3f(0.4f) + light * 0.55f : light);
  }
  Node node;
  node.name = name;
  node.mesh = scene.Add(Mesh{name, {std::move(primitive)}});
  scene.Add(node);
}

/// The large polygons: walls, gallery and tiles; each wall is of few, that reach past the camera.
void AddShell(GlbScene& scene, const Materials& materials) {
  Primitive walls;
  for (const float side : {-1.0f, 1.0f}) {
    const float x = side * kHalfWidth, z = side * kHalfLength;
    AddPolygon(walls, {V3f(x, 0, z), V3f(x, 0, -z), V3f(x, kHeight, -z), V3f(x, kHeight, z)});
    AddPolygon(walls, {V3f(-x, 0, z), V3f(x, 0, z), V3f(x, kHeight, z), V3f(-x, kHeight, z)});
  }
  MapByFacing(walls, 1 / kPlaster);
  AddNode(scene, "walls", materials.walls, std::move(walls));

  Primitive tiles[2];
  const int columns = 10, rows = 27;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const auto corner = [&](int x, int z) {
        return V3f((2.0f * float(x) / columns - 1) * kHalfWidth, 0,
                   (1 - 2.0f * float(z) / rows) * kHalfLength);
      };
      AddPolygon(tiles[(i + j) % 2],
                 {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
      // A slab of the picture, by chance.
      const V2f slab(std::floor(float(kSlabs * HashOf(i, j, 1))),
                     std::floor(float(kSlabs * HashOf(i, j, 2))));
      for (const V2f& place : {V2f(0, 1), V2f(1, 1), V2f(1, 0), V2f(0, 0)}) {
        tiles[(i + j) % 2].texcoords.push_back((slab + place) / kSlabs);
      }
    }
  }
  AddNode(scene, "tiles", materials.light_tiles, std::move(tiles[0]));
  AddNode(scene, "tiles", materials.dark_tiles, std::move(tiles[1]));

  Primitive gallery;
  for (const float side : {-1.0f, 1.0f}) {
    const float from = std::min(side * kAisle, side * kHalfWidth),
                to = std::max(side * kAisle, side * kHalfWidth);
    AddBox(gallery, V3f(from, 4.2f, -kHalfLength), V3f(to, 4.45f, kHalfLength));
    AddBox(gallery, V3f(side * kAisle - 0.09f, 5.3f, -kHalfLength),
           V3f(side * kAisle + 0.09f, 5.42f, kHalfLength));
    AddBox(gallery, V3f(from, kHeight - 0.3f, -kHalfLength), V3f(to, kHeight, kHalfLength));
  }
  MapByFacing(gallery, 1 / kBlocks);
  AddNode(scene, "gallery", materials.gallery, std::move(gallery));
}

/// A column from `foot` of `height`, thicker at foot and capital.
void AddColumn(Primitive& stone, const V3f& foot, float height, float radius, int sides = 24) {
  struct Ring {
    double radius, height;
  };
  const Ring rings[] = {{1.5, 0},    {1.5, 0.04}, {1.25, 0.05}, {1.3, 0.08}, {1, 0.1},
                        {0.98, 0.3}, {0.93, 0.6}, {0.88, 0.86}, {1.1, 0.88}, {0.95, 0.9},
                        {1.3, 0.95}, {1.6, 0.97}, {1.6, 1}};
  const int rows = int(std::size(rings)) - 1;
  AddSurface(stone, sides, rows, [&](double u, double v) {
    const Ring& r = rings[size_t(std::lround(v * rows))];
    const double angle = -2 * M_PI * u;
    return foot + V3f(float(radius * r.radius * std::cos(angle)), float(height * r.height),
                      float(radius * r.radius * std::sin(angle)));
  });
  // Every column is of another place of the marble, which goes round it a whole number of times, or to the
  // back and forth again where it is thin.
  const double girth = 2 * M_PI * double(radius) / double(kMarble), times = std::round(girth);
  const int number = int(std::lround(8 * foot.z)), side = foot.x > 0 ? 1 : -1;
  const V2f cut(float(HashOf(number, side, 1)), float(HashOf(number, side, 2)));
  MapSurface(stone, sides, rows, [&](double u, double v) {
    const double around = times >= 1 ? times * u : girth * (0.5 - std::abs(u - 0.5));
    return cut + V2f(float(around), -height * float(rings[size_t(std::lround(v * rows))].height) / kMarble);
  });
}

/// The wall over two columns at `z0` and `z1`, cut by a half circle: its front, its back and its soffit.
void AddArch(Primitive& stone, float x, float z0, float z1) {
  constexpr int kSteps = 24;
  constexpr float kThickness = 0.5f, kTop = 4.2f;
  const float middle = (z0 + z1) / 2, radius = (z1 - z0) / 2 - 0.3f;
  const auto arc = [&](double u) {
    const double angle = M_PI * u;
    return V3f(0, kSpring + radius * float(std::sin(angle)), middle - radius * float(std::cos(angle)));
  };
  for (const float side : {-1.0f, 1.0f}) {
    const V3f at(x + side * kThickness / 2, 0, 0);
    AddSurface(stone, kSteps, 2, [&](double u, double v) {
      const V3f low = arc(side > 0 ? 1 - u : u);
      return at + V3f(0, low.y + (kTop - low.y) * float(v), low.z);
    });
    for (const auto& [a, b] : {std::pair(z0, middle - radius), std::pair(middle + radius, z1)}) {
      std::vector<V3f> corners = {at + V3f(0, kSpring, b), at + V3f(0, kSpring, a), at + V3f(0, kTop, a),
                                  at + V3f(0, kTop, b)};
      if (side < 0) std::reverse(corners.begin(), corners.end());
      AddPolygon(stone, corners);
    }
  }
  MapByFacing(stone, 1 / kBlocks);
  AddSurface(stone, kSteps, 4,
             [&](double u, double v) { return arc(u) + V3f(x + kThickness * float(v - 0.5), 0, 0); });
  MapSurface(stone, kSteps, 4, [&](double u, double v) {
    return V2f(kThickness * float(v), radius * float(M_PI * u)) / kBlocks;
  });
}

/// A curtain that hangs in folds between two columns of the upper floor.
void AddCurtain(Primitive& cloth, float x, float z0, float z1, double phase) {
  AddSurface(cloth, 44, 24, [&](double u, double v) {
    const double fold = 0.1 * std::sin(2 * M_PI * 7 * u + phase) * (0.4 + 0.6 * (1 - v));
    const double sag = 0.18 * std::sin(M_PI * u) * (1 - v);
    return V3f(x + float(fold), float(0.65 + 2.25 * v + sag), z0 + (z1 - z0) * float(u));
  });
  MapSurface(cloth, 44, 24,
             [&](double u, double v) { return V2f((z1 - z0) * float(u), 2.25f * float(1 - v)) / kBanner; });
}

/// A round vase for every second bay.
void AddVase(Primitive& clay, const V3f& foot) {
  AddSurface(clay, 24, 16, [&](double u, double v) {
    const double angle = -2 * M_PI * u;
    const double radius = 0.12 + 0.26 * std::pow(std::sin(M_PI * (0.08 + 0.8 * v)), 2) + (v > 0.9 ? 0.06 : 0);
    return foot + V3f(float(radius * std::cos(angle)), float(1.1 * v), float(radius * std::sin(angle)));
  });
  MapSurface(clay, 24, 16, [](double u, double v) { return V2f(float(2 * u), float(1 - v)); });
}

}  // namespace

/// A hall of columns, arches and galleries from within, whose walls, floor and ledges are few large polygons
/// that pass beside and behind the camera; the camera turns. About 66,000 triangles, most in the ornament.
GlbScene MakeHall(const SceneOptions& options) {
  const double motion = options.motion_pixels.value_or(32);
  GlbScene scene;
  const Materials materials = options.textured ? AddTexturedMaterials(scene) : AddPlainMaterials(scene);
  AddShell(scene, materials);
  for (const float side : {-1.0f, 1.0f}) {
    const float x = side * kAisle;
    for (int i = 0; i <= kBays; ++i) {
      const float z = -kHalfLength + kBay * float(i);
      // Plain columns and arches are of one stone and one mesh; of two stones they are two.
      Primitive columns, blocks;
      AddColumn(columns, V3f(x, 0, z), kSpring, 0.27f);
      AddColumn(columns, V3f(x, 5.42f, z), kHeight - 0.3f - 5.42f, 0.16f);
      for (int k = 1; k < 8 && i < kBays; ++k) {  // Balusters.
        AddColumn(columns, V3f(x, 4.45f, z + kBay * float(k) / 8), 0.85f, 0.05f, 6);
      }
      if (i < kBays) AddArch(options.textured ? blocks : columns, x, z, z + kBay);
      AddNode(scene, "bay", materials.columns, std::move(columns));
      if (!blocks.positions.empty()) AddNode(scene, "arch", materials.arches, std::move(blocks));
      if (i == kBays) continue;
      if (i % 2 == (side > 0 ? 1 : 0)) {
        Primitive curtain;
        AddCurtain(curtain, side * (kAisle + 0.35f), z + 0.35f, z + kBay - 0.35f, i);
        AddNode(scene, "curtain", materials.cloths[i % 3], std::move(curtain));
      } else {
        Primitive clay;
        AddVase(clay, V3f(side * (kAisle - 0.5f), 0, z + kBay / 2));
        AddNode(scene, "vase", materials.vase, std::move(clay));
      }
    }
  }
  Material blue;
  blue.name = "sky";
  blue.color = Srgb(0xa9cbe8);
  Primitive sky;
  sky.material = scene.Add(blue);
  AddPolygon(sky, {V3f(-900, 40, -900), V3f(900, 40, -900), V3f(900, 40, 900), V3f(-900, 40, 900)});
  sky.normals.clear();
  Node above;
  above.name = "sky";
  above.mesh = scene.Add(Mesh{"sky", {std::move(sky)}});
  scene.Add(above);

  if (!options.textured) DropTexcoords(scene);

  const V3f eye(1.6f, 1.9f, 9.2f), target(-0.9f, 2.3f, 0);
  // Pixels at the middle of the picture, where a metre at a distance of one metre is a radian.
  const double degrees = motion / PixelsPerMetre(kYfov, 1) * 180 / M_PI;
  const int camera = scene.Add(CameraNode(scene, {kYfov, 4.0 / 3, 0.1}, eye, target));
  if (motion > 0) {
    scene.channels.push_back(
        SwingRotation(camera, V3f(0, 1, 0), degrees, scene.nodes[size_t(camera)].rotation));
  }
  return scene;
}

}  // namespace shutterline::scenes
