#pragma once

#include "common/math/spaces.h"

/// Points on Bezier curves of degree 1 to 3 in homogeneous space [gribel2013, equation 1].
namespace shutterline {

inline constexpr int kMaxBezierDegree = 3;

/// Where shutter time falls on a motion of several equal pieces.
struct CurvePosition {
  int piece = 0;
  double u = 0;  ///< In [0, 1] within the piece.
};

/// `pieces` is a power of two, so u is exact. A joint belongs to the piece that starts there; t = 1 is the
/// end of the last piece.
inline CurvePosition CurvePositionAt(int pieces, double t) {
  if (pieces == 1) return {0, t};
  const double scaled = t * pieces;
  const int piece = scaled >= pieces ? pieces - 1 : scaled > 0 ? int(scaled) : 0;
  return {piece, scaled - piece};
}

/// The point at u in [0, 1] of the curve with control points `c[0..degree]`. Exactly an end point at u = 0
/// and u = 1; where degree > 1 and all control points are equal, exactly that point. Reversing points and u
/// changes no bit.
inline RasterPoint BezierPoint(const RasterPoint* c, int degree, double u) {
  const double v = 1 - u;
  switch (degree) {
    case 0:
      return c[0];
    case 1:
      return v * c[0] + u * c[1];
    case 2:
      if (c[0] == c[1] && c[0] == c[2]) return c[0];
      return ((v * v) * c[0] + (u * u) * c[2]) + (2 * (u * v)) * c[1];
    default:
      if (c[0] == c[1] && c[0] == c[2] && c[0] == c[3]) return c[0];
      return ((v * v * v) * c[0] + (u * u * u) * c[3]) +
             ((3 * (v * v * u)) * c[1] + (3 * (u * u * v)) * c[2]);
  }
}

/// The control points of the curve's part over [a, b], by blossoming.
inline void BezierPart(const RasterPoint* c, int degree, double a, double b, RasterPoint* part) {
  const auto mix = [](const RasterPoint& p, const RasterPoint& q, double u) { return (1 - u) * p + u * q; };
  if (degree == 0) {
    part[0] = c[0];
  } else if (degree == 1) {
    part[0] = mix(c[0], c[1], a);
    part[1] = mix(c[0], c[1], b);
  } else if (degree == 2) {
    const auto blossom = [&](double u, double v) { return mix(mix(c[0], c[1], u), mix(c[1], c[2], u), v); };
    part[0] = blossom(a, a);
    part[1] = blossom(a, b);
    part[2] = blossom(b, b);
  } else {
    const auto blossom = [&](double u, double v, double w) {
      const RasterPoint p = mix(c[0], c[1], u), q = mix(c[1], c[2], u), r = mix(c[2], c[3], u);
      return mix(mix(p, q, v), mix(q, r, v), w);
    };
    part[0] = blossom(a, a, a);
    part[1] = blossom(a, a, b);
    part[2] = blossom(a, b, b);
    part[3] = blossom(b, b, b);
  }
}

/// The same curve as a polynomial in u, for tight loops: c0 + u (c1 + u (c2 + u c3)), in `c` of degree + 1
/// entries. For a point at rest all but the first are exactly zero, so it stays bit for bit where it is; at
/// u = 1 the last rounding may miss the end point.
inline void BezierToPower(const RasterPoint* points, int degree, RasterPoint* c) {
  c[0] = points[0];
  if (degree == 0) return;
  const RasterPoint d01 = points[1] - points[0];
  if (degree == 1) {
    c[1] = d01;
    return;
  }
  const RasterPoint d12 = points[2] - points[1];
  c[1] = double(degree) * d01;
  if (degree == 2) {
    c[2] = d12 - d01;
    return;
  }
  const RasterPoint d23 = points[3] - points[2];
  c[2] = 3.0 * (d12 - d01);
  c[3] = (d23 - d12) - (d12 - d01);
}

/// BezierToPower's polynomial at u.
inline RasterPoint PowerPoint(const RasterPoint* c, int degree, double u) {
  RasterPoint p = c[degree];
  for (int i = degree - 1; i >= 0; --i) p = c[i] + u * p;
  return p;
}

}  // namespace shutterline
