#pragma once

#include <cstdint>

#include "common/math/spaces.h"

namespace shutterline::engine {

/// Radiance from point to point of triangles for which no polynomial says it, but which is cheap to ask for.
/// Of one tile and one thread.
class PointColors {
 public:
  virtual ~PointColors() = default;

  /// Whether the triangle of the frame is one of these.
  virtual bool Has(uint32_t triangle) const = 0;
  /// A number under which one of these is asked for.
  virtual uint32_t Prepare(uint32_t triangle) = 0;
  /// The radiance there, at barycentric coordinates.
  virtual V3f At(uint32_t prepared, double b1, double b2) = 0;
};

}  // namespace shutterline::engine
