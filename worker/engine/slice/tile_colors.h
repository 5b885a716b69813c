#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/engine/slice/tile_mesh.h"
#include "worker/engine/visibility/color_film.h"
#include "worker/engine/visibility/line_position.h"

namespace shutterline::engine {

/// How a triangle's colour is known.
enum class ColorKind : uint8_t {
  kUnknown,   ///< Not looked at yet.
  kConstant,  ///< One colour.
  kSmooth,    ///< Linear or quadratic over it, or else known at every point.
  kApart,     ///< By shading each of its pixels: it is kept apart.
};

/// The colours of a tile's triangles, each looked at when it is first seen. Keeps its memory.
class TileColors {
 public:
  using Color = std::array<double, 4>;  ///< Radiance and coverage.

  /// Begins a tile. `film` may be null: everything is kept apart by triangle then.
  void Begin(const TileMesh& mesh, ColorFilm* film);

  /// The same, but a triangle has the colour that the film guesses, where it does.
  void BeginGuessing(const TileMesh& mesh, ColorFilm& film);

  ColorFilm* film() const { return film_; }
  /// What goes to the film is to be told by triangle as well.
  bool keeps_pairs() const { return keeps_pairs_; }

  /// Of a triangle of the tile's mesh.
  ColorKind KindOf(uint32_t index) {
    if (film_ == nullptr) return ColorKind::kApart;
    if (kinds_[index] == ColorKind::kUnknown) Shade(index);
    return kinds_[index];
  }

  /// Has KindOf been asked of it?
  bool WasSeen(uint32_t index) const { return kinds_[index] != ColorKind::kUnknown; }

  /// Of one that was seen: does the film's PointColors know its colour?
  bool IsByPoints(uint32_t index) const { return smooth_[index].by_points; }
  /// Its number there, if it is kSmooth.
  uint32_t PreparedOf(uint32_t index) const { return smooth_[index].prepared; }

  /// Along a line points are looked at once every 2^-PartsLog2 pixels. Where a triangle moves, its motion
  /// blurs what lies between them.
  int PartsLog2(uint32_t index) const { return mesh_->triangles()[index].moves ? 0 : 2; }
  /// Of a constant one.
  const Color& ColorOf(uint32_t index) const { return colors_[index]; }
  /// Of a smooth one at `l` pixels along a line. Rounding does not leave the triangle.
  Color ColorAt(uint32_t index, const LinePosition& position, double l) const;
  /// The mean of a smooth one between two subpixels of a step.
  Color MeanColor(uint32_t index, const LinePosition& position, int32_t begin, int32_t end) const;

 private:
  /// Coefficients of 1, b1, b2, b1², b1 b2, b2²; or the film is asked point by point.
  struct Smooth {
    std::array<Color, 6> coefficients;
    bool quadratic = false, by_points = false;
    uint32_t prepared = 0;  ///< Of PointColors.
  };

  void Shade(uint32_t index);
  void ShadeByPoints(uint32_t index);
  void SetConstant(uint32_t index, const V3f& color);

  const TileMesh* mesh_ = nullptr;
  ColorFilm* film_ = nullptr;
  bool guesses_ = false, keeps_pairs_ = false;
  // By triangle of the mesh.
  std::vector<ColorKind> kinds_;
  std::vector<Color> colors_;
  std::vector<Smooth> smooth_;
};

}  // namespace shutterline::engine
