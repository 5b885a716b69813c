#include "worker/engine/sampling/shutter_curve.h"

#include <algorithm>
#include <cmath>

namespace shutterline::engine {

ShutterCurve::ShutterCurve(const std::vector<ShutterPoint>& points) {
  double light = 0;
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const ShutterPoint& a = points[i];
    const ShutterPoint& b = points[i + 1];
    Piece piece{.begin = a.time,
                .length = b.time - a.time,
                .light_before = light,
                .light_after = 0,
                .opening = a.opening,
                .change = b.opening - a.opening};
    light += 0.5 * (a.opening + b.opening) * piece.length;
    piece.light_after = light;
    pieces_.push_back(piece);
  }
}

double ShutterCurve::Invert(double u) const {
  const double light = u * pieces_.back().light_after;
  auto piece =
      std::find_if(pieces_.begin(), pieces_.end(), [&](const Piece& p) { return light < p.light_after; });
  if (piece == pieces_.end()) --piece;
  // Within the piece, opening · x + change · x² / 2 of it has come in at part x: the root without
  // cancellation.
  const double wanted = (light - piece->light_before) / piece->length;
  const double root = std::sqrt(std::max(0.0, piece->opening * piece->opening + 2 * piece->change * wanted));
  const double sum = piece->opening + root;
  const double part = sum > 0 ? 2 * wanted / sum : 0;
  constexpr double kBeforeOne = 1 - 0x1p-53;
  return std::clamp(piece->begin + part * piece->length, 0.0, kBeforeOne);
}

}  // namespace shutterline::engine
