#include "tests/stability/hard_case.h"

#include <utility>

#include "worker/engine/visibility/segment.h"

namespace shutterline::engine::hard_case {
namespace {

RasterPoint Changed(RasterPoint p, const Variant& variant) {
  if (variant.mirror) p.x = p.w - p.x;
  if (variant.swap) std::swap(p.x, p.y);
  p.x += variant.dx * p.w;
  p.y += variant.dy * p.w;
  return p;
}

}  // namespace

std::string Variant::Name() const {
  return "moved by (" + std::to_string(dx) + ", " + std::to_string(dy) + ")" + (mirror ? ", mirrored" : "") +
         (swap ? ", x and y exchanged" : "") + (reverse ? ", time reversed" : "");
}

std::vector<Variant> AllVariants() {
  std::vector<Variant> variants;
  for (int i = 0; i < 8; ++i) {
    variants.push_back({.dx = i % 3 * 7,
                        .dy = i % 2 * 13,
                        .mirror = (i & 1) != 0,
                        .swap = (i & 2) != 0,
                        .reverse = (i & 4) != 0});
  }
  return variants;
}

std::vector<Variant> VariantsThatKeepLines() {
  return {{}, {.dx = 5, .dy = 11}, {.reverse = true}, {.dx = 31, .dy = 30, .reverse = true}};
}

RasterPoint At(double x, double y, double depth) {
  return {x, y, depth, 1};
}

void AddQuad(Case& c, const std::array<RasterPoint, 4>& open, const std::array<RasterPoint, 4>& close) {
  c.triangles.push_back({{open[0], open[1], open[2]}, {close[0], close[1], close[2]}});
  c.triangles.push_back({{open[0], open[2], open[3]}, {close[0], close[2], close[3]}});
}

void AddRectangle(Case& c, double x0, double y0, double x1, double y1, double vx, double vy, double depth) {
  const auto corners = [&](double dx, double dy) -> std::array<RasterPoint, 4> {
    return {At(x0 + dx, y0 + dy, depth), At(x1 + dx, y0 + dy, depth), At(x1 + dx, y1 + dy, depth),
            At(x0 + dx, y1 + dy, depth)};
  };
  AddQuad(c, corners(0, 0), corners(vx, vy));
}

RenderSettings SettingsOf(ResolverKind resolver, PatternKind pattern, int instants) {
  RenderSettings settings = LineSettings(pattern, instants);
  settings.resolver = resolver;
  settings.time_cells = 1 + instants % 5;
  return settings;
}

Answer Resolve(const Case& c, PatternKind pattern, int instants, const Variant& variant) {
  return Resolve(c, LineSettings(pattern, instants), variant);
}

std::shared_ptr<const FrameScene> FrameOf(const Case& c, const Variant& variant, const FrameView& view,
                                          const std::vector<V3f>& colors) {
  FrameSceneBuilder builder(view);
  for (size_t k = 0; k < c.triangles.size(); ++k) {
    std::array<RasterPoint, 3> open;
    std::array<RasterPoint, 3> close;
    for (size_t i = 0; i < 3; ++i) {
      open[i] = Changed(c.triangles[k].open[i], variant);
      close[i] = Changed(c.triangles[k].close[i], variant);
    }
    // Mirroring and exchanging axes turn a triangle over: keep the side that is seen.
    if (variant.mirror != variant.swap) {
      std::swap(open[1], open[2]);
      std::swap(close[1], close[2]);
    }
    if (variant.reverse) std::swap(open, close);
    FlatLook look{.double_sided = c.double_sided};
    if (!colors.empty()) look.color = colors[k];
    builder.AddRasterTriangle(open, close, look);
  }
  return builder.Build();
}

Answer Resolve(const Case& c, const RenderSettings& settings, const Variant& variant) {
  const auto frame = FrameOf(c, variant, OrthographicView(64, 64));
  const TileRect tile{0, 0, 32, 32};
  const ResolvedTile resolved(*frame, tile, settings);
  Answer answer;
  for (uint32_t i = 0; i < c.triangles.size(); ++i) {
    answer.coverage.push_back(resolved.Coverage(variant.dx, variant.dy, i));
  }
  answer.sum = resolved.Coverage(variant.dx, variant.dy);
  answer.background = resolved.Background(variant.dx, variant.dy);
  return answer;
}

double LineCoverage(const Case& c, double height, int instants, double offset) {
  const SegmentLine line{
      .major_is_x = true, .slope = 0, .intercept = height, .begin = 0, .end = kSubpixelsPerPixel};
  double covered = 0;
  for (const MovingTriangle& source : c.triangles) {
    TileTriangle triangle;
    triangle.open = source.open;
    triangle.close = source.close;
    triangle.moves = true;
    triangle.cull_back = !c.double_sided;
    triangle.crosses_near = true;
    for (int i = 0; i < instants; ++i) {
      LineSegment segment;
      if (MakeSegment(triangle, 0, 0, line, (i + offset) / instants, &segment, nullptr)) {
        covered += double(segment.end - segment.begin) / kSubpixelsPerPixel;
      }
    }
  }
  return covered / instants;
}

double FittedSlope(const std::vector<int>& n, const std::vector<double>& error) {
  double sx = 0;
  double sy = 0;
  double sxx = 0;
  double sxy = 0;
  for (size_t i = 0; i < n.size(); ++i) {
    const double x = std::log2(n[i]);
    const double y = std::log2(error[i]);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  const auto count = double(n.size());
  return (count * sxy - sx * sy) / (count * sxx - sx * sx);
}

double SlidingRectangle(double x0, double a, double v) {
  const auto ramp = [](double z) { return z < 0 ? 0 : z <= 1 ? z * z / 2 : z - 0.5; };
  return (ramp(x0 + a + v) - ramp(x0 + a) - ramp(x0 + v) + ramp(x0)) / v;
}

Case Sliding(double x0, double a, double v) {
  Case c;
  AddRectangle(c, x0, -50, x0 + a, 50, v, 0);
  return c;
}

}  // namespace shutterline::engine::hard_case
