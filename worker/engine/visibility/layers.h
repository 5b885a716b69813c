#pragma once

#include <cstdint>

namespace shutterline::engine {

/// How much of what lies behind it a point of a triangle hides: the alpha of a material that is not opaque.
/// Thread-safe.
class AlphaSource {
 public:
  virtual ~AlphaSource() = default;

  /// Of a layer (PrimitiveTraits::layer), in [0, 1], at barycentric coordinates, at shutter time t. Alpha as
  /// the material gives it: cut-offs have not been looked at.
  virtual double AlphaAt(uint32_t triangle, double b1, double b2, double t) const = 0;
};

}  // namespace shutterline::engine
