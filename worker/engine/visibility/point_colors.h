#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/math/spaces.h"
#include "worker/engine/visibility/line_position.h"
#include "worker/engine/visibility/line_spread.h"

namespace shutterline::engine {

/// Radiance from point to point of triangles for which no polynomial says it, but which is cheap to ask for.
/// Of one tile and one thread.
class PointColors {
 public:
  using Color = std::array<double, 4>;  ///< Radiance and coverage.

  virtual ~PointColors() = default;

  /// Whether the triangle of the frame is one of these.
  virtual bool Has(uint32_t triangle) const = 0;
  /// The radiance of one of these all over it, if it is the same.
  virtual std::optional<V3f> ColorOfAll(uint32_t triangle) = 0;
  /// A number under which one of these is asked for point by point.
  virtual uint32_t Prepare(uint32_t triangle) = 0;
  /// The radiance there, at barycentric coordinates.
  virtual V3f At(uint32_t prepared, double b1, double b2) = 0;
  /// A piece of a line, subpixels, and how it is looked at: once every 2^-parts_log2 pixels.
  struct Piece {
    int32_t begin = 0, end = 0;
    int parts_log2 = 0;
  };
  /// Adds what a line sees along a piece to the sums of its steps: of each part the colour in its middle,
  /// times its subpixels and `weight`. It may do so as late as in Finish, but for each sum in the order in
  /// which it is called.
  virtual void AddAlong(uint32_t prepared, const LinePosition& position, const Piece& piece, double weight,
                        Color* sums_of_line) = 0;
  /// The same under a filter: `sums_of_line` are by step and tap.
  virtual void SpreadAlong(uint32_t prepared, const LinePosition& position, const Piece& piece, double weight,
                           const LineSpread& spread, Color* sums_of_line) = 0;
  virtual void Finish() = 0;
};

}  // namespace shutterline::engine
