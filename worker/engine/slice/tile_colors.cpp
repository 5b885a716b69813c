#include "worker/engine/slice/tile_colors.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/math/tolerance.h"

namespace shutterline::engine {
namespace {

/// Colours are taken as one where they differ by less than this over a triangle: far below what eight bits
/// show.
constexpr double kColorTolerance = 1e-3;

}  // namespace

void TileColors::BeginGuessing(const TileMesh& mesh, ColorFilm& film) {
  Begin(mesh, &film);
  guesses_ = true;
  keeps_pairs_ = false;
}

void TileColors::Begin(const TileMesh& mesh, ColorFilm* film) {
  mesh_ = &mesh;
  film_ = film;
  guesses_ = false;
  keeps_pairs_ = film != nullptr && film->keeps_pairs();
  if (film == nullptr) return;
  const size_t count = mesh.triangles().size();
  kinds_.assign(count, ColorKind::kUnknown);
  if (colors_.size() >= count) return;
  colors_.resize(count);
  smooth_.resize(count);
}

void TileColors::Shade(uint32_t index) {
  const uint32_t id = mesh_->triangles()[index].id;
  if (guesses_) {
    const std::optional<V3f> guess = film_->Guess(id);
    return guess ? SetConstant(index, *guess) : ShadeByPoints(index);
  }
  const std::optional<ColorNodes> nodes = film_->Shade(id);
  if (!nodes && film_->HasPoints(id)) return ShadeByPoints(index);
  if (!nodes) {
    kinds_[index] = ColorKind::kApart;
    smooth_[index].by_points = false;
    return;
  }
  double range = 0;
  const auto measure = [&](const V3f& color) {
    for (int c = 0; c < 3; ++c) range = std::max(range, std::abs(double(color[c] - nodes->corners[0][c])));
  };
  for (const V3f& color : nodes->corners) measure(color);
  if (nodes->quadratic) {
    for (const V3f& color : nodes->middles) measure(color);
  }
  colors_[index][3] = 1;
  smooth_[index] = {.coefficients = {}, .quadratic = nodes->quadratic, .by_points = false, .prepared = 0};
  for (int c = 0; c < 3; ++c) {
    const auto k = size_t(c);
    const double f0 = nodes->corners[0][c];
    const double f1 = nodes->corners[1][c];
    const double f2 = nodes->corners[2][c];
    colors_[index][k] = range == 0 ? f0 : (f0 + f1 + f2) / 3;
    std::array<Color, 6>& a = smooth_[index].coefficients;
    a[0][k] = f0;
    a[1][k] = f1 - f0;
    a[2][k] = f2 - f0;
    if (!nodes->quadratic) continue;
    // Through the corners and the middles m01, m12, m20.
    const double m01 = nodes->middles[0][c];
    const double m12 = nodes->middles[1][c];
    const double m20 = nodes->middles[2][c];
    a[1][k] = 4 * m01 - 3 * f0 - f1;
    a[2][k] = 4 * m20 - 3 * f0 - f2;
    a[3][k] = 2 * (f0 + f1) - 4 * m01;
    a[4][k] = 4 * (f0 + m12 - m01 - m20);
    a[5][k] = 2 * (f0 + f2) - 4 * m20;
  }
  kinds_[index] = range < kColorTolerance ? ColorKind::kConstant : ColorKind::kSmooth;
}

void TileColors::ShadeByPoints(uint32_t index) {
  PointColors& points = film_->points();
  const uint32_t id = mesh_->triangles()[index].id;
  if (const std::optional<V3f> color = points.ColorOfAll(id)) {
    SetConstant(index, *color);
  } else {
    kinds_[index] = ColorKind::kSmooth;
    smooth_[index].prepared = points.Prepare(id);
  }
  smooth_[index].by_points = true;
}

void TileColors::SetConstant(uint32_t index, const V3f& color) {
  colors_[index] = {double(color.x), double(color.y), double(color.z), 1};
  kinds_[index] = ColorKind::kConstant;
  smooth_[index].by_points = false;
}

TileColors::Color TileColors::ColorAt(uint32_t index, const LinePosition& position, double l) const {
  const Smooth& smooth = smooth_[index];
  const std::array<Color, 6>& a = smooth.coefficients;
  const double over = 1 / (position.at[2] + position.per_pixel[2] * l);
  const double b1 = ClampedFromZero((position.at[0] + position.per_pixel[0] * l) * over, 1);
  const double b2 = ClampedFromZero((position.at[1] + position.per_pixel[1] * l) * over, 1 - b1);
  if (smooth.by_points) {
    const V3f radiance = film_->points().At(smooth.prepared, b1, b2);
    return {double(radiance.x), double(radiance.y), double(radiance.z), 1};
  }
  Color color;
  for (size_t c = 0; c < 3; ++c) {
    color[c] = a[0][c] + b1 * a[1][c] + b2 * a[2][c];
    if (smooth.quadratic) color[c] += b1 * (b1 * a[3][c] + b2 * a[4][c]) + b2 * b2 * a[5][c];
  }
  color[3] = 1;
  return color;
}

TileColors::Color TileColors::MeanColor(uint32_t index, const LinePosition& position, int32_t begin,
                                        int32_t end) const {
  const int parts = IsByPoints(index) ? 1 << PartsLog2(index) : 1;
  const double part = (double(end) - double(begin)) / (kSubpixelsPerPixel * double(parts));
  Color mean{};
  for (int i = 0; i < parts; ++i) {
    const double l = double(begin) / kSubpixelsPerPixel + (i + 0.5) * part;
    const Color color = ColorAt(index, position, l);
    for (size_t c = 0; c < 4; ++c) mean[c] += color[c] / parts;
  }
  return mean;
}

}  // namespace shutterline::engine
