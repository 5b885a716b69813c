#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <string>

#include "tests/scenes/chess_pieces.h"
#include "tests/scenes/keys.h"
#include "tests/scenes/marble.h"
#include "tests/scenes/noise.h"
#include "tests/scenes/random.h"
#include "tests/scenes/scene_functions.h"
#include "tests/scenes/shapes.h"
#include "tests/scenes/stone.h"
#include "tests/scenes/texcoords.h"
#include "tests/scenes/wood.h"

namespace shutterline::scenes {
namespace {

constexpr double kYfov = 32 * M_PI / 180;
const V3f kEye(-4.3f, 6.9f, 12.6f), kTarget(0.1f, 0.6f, 0.1f);

// The game, seen from white; capitals are white's. The others are in the air.
constexpr const char* kBoard[8] = {"r...k..r", "pp...ppp", "..n.b...", "...p....",
                                   "...P.B..", "..N.....", "PP...PPP", "R..QK..R"};
constexpr const char* kInTheAir = "bnqpppBNPPP";

int AddMaterial(GlbScene& scene, const char* name, uint32_t rgb) {
  Material material;
  material.name = name;
  material.color = Srgb(rgb);
  material.unlit = false;
  return scene.Add(material);
}

/// Numbers of the scene's materials.
struct Materials {
  int light_squares, dark_squares, frame, table, white, black;
};

Materials AddPlainMaterials(GlbScene& scene) {
  return {AddMaterial(scene, "light squares", 0xead7b7), AddMaterial(scene, "dark squares", 0x7a4f35),
          AddMaterial(scene, "frame", 0x4a2c1d),         AddMaterial(scene, "table", 0x5d737e),
          AddMaterial(scene, "white", 0xf3e9d2),         AddMaterial(scene, "black", 0x3d3a4b)};
}

/// A board of maple, walnut and mahogany on slabs of slate, pieces of white marble and of rosewood.
Materials AddTexturedMaterials(GlbScene& scene) {
  const auto add = [&](const char* name, const SurfaceMap& map) {
    return AddSurfaceMaterial(scene, name, AddImages(scene, name, map));
  };
  return {add("maple", Wood(512, Maple(), 1)),
          add("walnut", Wood(512, Walnut(), 2)),
          add("mahogany", Wood(512, Mahogany(), 3)),
          add("slate", FloorTiles(1024, Slate(), 4, 4)),
          add("white marble", Marble(512, WhiteMarble(), 5)),
          add("rosewood", Wood(512, Rosewood(), 6))};
}

V3f Square(int column, int row) {
  return V3f(float(column) - 3.5f, 0, float(row) - 3.5f);
}

/// Squares of 5 × 5 cells, darker beside the pieces that stand there, on a frame and a table.
void AddBoard(GlbScene& scene, const Materials& materials) {
  constexpr int kCells = 5;
  constexpr float kBoardsPerMetre = 1 / 2.5f, kSlatesPerMetre = 1 / 10.0f;  // Pictures a metre.
  std::vector<Primitive> board(3);
  board[0].material = materials.light_squares;
  board[1].material = materials.dark_squares;
  const auto shade = [](const V3f& p) {
    float light = 1;
    for (int row = 0; row < 8; ++row) {
      for (int column = 0; column < 8; ++column) {
        if (kBoard[row][column] == '.') continue;
        const float away = (p - Square(column, row)).length();
        light *= 1 - 0.75f * std::exp(-6 * away * away);
      }
    }
    return V3f(light);
  };
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 8; ++column) {
      Primitive& squares = board[size_t((row + column) % 2)];
      const V3f centre = Square(column, row);
      AddSurface(squares, kCells, kCells,
                 [&](double u, double v) { return centre + V3f(float(u) - 0.5f, 0, 0.5f - float(v)); });
      // Every square is cut from another place of the wood.
      const V2f cut(float(HashOf(column, row, 1)), float(HashOf(column, row, 2)));
      MapSurface(squares, kCells, kCells,
                 [&](double u, double v) { return cut + V2f(float(u), float(1 - v)) * kBoardsPerMetre; });
    }
  }
  for (Primitive& squares : board) {
    for (const V3f& p : squares.positions) squares.colors.push_back(shade(p));
  }
  board[2].material = materials.frame;
  AddBox(board[2], V3f(-4.5f, -0.3f, 4), V3f(4.5f, 0.02f, 4.5f));
  AddBox(board[2], V3f(-4.5f, -0.3f, -4.5f), V3f(4.5f, 0.02f, -4));
  MapByFacing(board[2], kBoardsPerMetre, V2f(0), /*turned=*/true);  // The grain runs along the planks.
  AddBox(board[2], V3f(4, -0.3f, -4), V3f(4.5f, 0.02f, 4));
  AddBox(board[2], V3f(-4.5f, -0.3f, -4), V3f(-4, 0.02f, 4));
  MapByFacing(board[2], kBoardsPerMetre);
  Node node;
  node.name = "board";
  node.mesh = scene.Add(Mesh{"board", std::move(board)});
  scene.Add(node);

  Primitive table;
  table.material = materials.table;
  AddSurface(table, 8, 8, [](double u, double v) {
    return V3f(float(120 * (u - 0.5)), -0.3f, float(120 * (0.5 - v) - 40));
  });
  MapByFacing(table, kSlatesPerMetre);
  Node under;
  under.name = "table";
  under.mesh = scene.Add(Mesh{"table", {std::move(table)}});
  scene.Add(under);
}

}  // namespace

/// A game from which the taken pieces fly off, tumbling, over those that still stand: many triangles
/// smaller than a pixel, static edges beside fast ones.
GlbScene MakeChess(const SceneOptions& options) {
  const double motion = options.motion_pixels.value_or(40);
  GlbScene scene;
  const Materials materials = options.textured ? AddTexturedMaterials(scene) : AddPlainMaterials(scene);
  AddBoard(scene, materials);
  std::map<char, int> mesh_of;
  for (const char kind : std::string("PRNBQKprnbqk")) {
    Primitive piece = MakeChessPiece(char(std::toupper(kind)));
    piece.material = std::isupper(kind) ? materials.white : materials.black;
    mesh_of[kind] = scene.Add(Mesh{std::string(1, kind), {std::move(piece)}});
  }
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 8; ++column) {
      const char kind = kBoard[row][column];
      if (kind == '.') continue;
      Node node;
      node.name = std::string(1, kind);
      node.translation = Square(column, row);
      node.rotation = Turn(V3f(0, 1, 0), std::isupper(kind) ? 180 : 0);
      node.mesh = mesh_of[kind];
      scene.Add(node);
    }
  }

  // Pieces turn about their middle: a node that moves, with a child that holds the piece.
  Random random(options.seed);
  const int count = int(std::string(kInTheAir).size());
  for (int i = 0; i < count; ++i) {
    const char kind = kInTheAir[i];
    Node piece;
    piece.name = std::string(1, kind);
    piece.translation = V3f(0, -0.5f, 0);
    piece.mesh = mesh_of[kind];
    const int child = scene.Add(piece);
    Node centre;
    centre.name = "tumbling";
    const double angle = 2 * M_PI * (i + random.Uniform(-0.3, 0.3)) / count;
    const double away = random.Uniform(1.2, 3.6);
    centre.translation = V3f(float(away * std::cos(angle)), float(random.Uniform(1.2, 2.9)),
                             float(0.2 + 0.8 * away * std::sin(angle)));
    centre.children = {child};
    const int node = scene.Add(centre);
    const double depth = (kTarget - kEye).normalized().dot(centre.translation - kEye);
    const double part = random.Uniform(0.15, 0.6);  // Of the motion; what turns adds to it.
    const V3f flight =
        (V3f(centre.translation.x, 0, centre.translation.z).normalized() + random.Direction() * 0.6f)
            .normalized();
    const V3f way = flight * float(part * motion / PixelsPerMetre(kYfov, depth));
    const V3f axis = random.Direction();
    const double start = random.Uniform(0, 360), degrees = random.Uniform(10, 40) * motion / 40;
    if (motion > 0) {
      scene.channels.push_back(SwingTranslation(node, centre.translation, way));
      scene.channels.push_back(Spin(node, axis, start, degrees));
    } else {
      scene.nodes[size_t(node)].rotation = Turn(axis, start);
    }
  }
  if (!options.textured) DropTexcoords(scene);
  scene.Add(CameraNode(scene, {kYfov}, kEye, kTarget));
  return scene;
}

}  // namespace shutterline::scenes
