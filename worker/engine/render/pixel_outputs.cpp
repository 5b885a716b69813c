#include "worker/engine/render/pixel_outputs.h"

#include <algorithm>
#include <array>
#include <limits>
#include <tuple>

#include "common/base/check.h"
#include "common/job/output_channels.h"
#include "worker/engine/scene/scene_names.h"
#include "worker/engine/shading/footprint.h"

namespace shutterline::engine {
namespace {

constexpr double kMidShutter = 0.5;

/// An order that does not depend on how triangles are numbered, as far as sums can tell.
bool OrderOfSums(const SeenPair& a, const SeenPair& b) {
  const auto key = [](const SeenPair& s) {
    return std::tie(s.weight, s.depth, s.position.x, s.position.y, s.position.z, s.normal.x, s.normal.y,
                    s.normal.z, s.albedo.x, s.albedo.y, s.albedo.z, s.motion.x, s.motion.y, s.open);
  };
  return key(a) < key(b);
}

RasterPoint PointAt(const FrameScene& frame, uint32_t triangle, const Barycentric& at, double t) {
  const std::array<RasterPoint, 3> p = CornersAt(frame, triangle, t);
  return p[0] + (at.b1 * (p[1] - p[0]) + at.b2 * (p[2] - p[0]));
}

/// Raster displacement over the shutter, pixels; nothing where the point is behind the camera at an end of
/// it.
V2d MotionOf(const FrameScene& frame, uint32_t triangle, const Barycentric& at) {
  const RasterPoint open = PointAt(frame, triangle, at, 0), close = PointAt(frame, triangle, at, 1);
  if (!(open.w > 0 && close.w > 0)) return {0, 0};
  return {close.x / close.w - open.x / open.w, close.y / close.w - open.y / open.w};
}

/// The index with the greatest weight; the least of equals.
int Heaviest(std::span<const std::pair<int, uint64_t>> weights) {
  std::vector<std::pair<int, uint64_t>> sums(weights.begin(), weights.end());
  std::sort(sums.begin(), sums.end());
  int best = -1;
  uint64_t most = 0;
  for (size_t i = 0; i < sums.size();) {
    uint64_t sum = 0;
    const int index = sums[i].first;
    for (; i < sums.size() && sums[i].first == index; ++i) sum += sums[i].second;
    if (sum > most) {
      most = sum;
      best = index;
    }
  }
  return best;
}

/// Appends to a pixel's floats.
class Writer {
 public:
  explicit Writer(std::span<float> out) : out_(out) {}
  void Put(double value) { out_[at_++] = float(value); }
  void Put(const V3d& value) {
    for (int c = 0; c < 3; ++c) Put(value[c]);
  }
  std::span<float> Next(size_t count) {
    at_ += count;
    return out_.subspan(at_ - count, count);
  }

 private:
  std::span<float> out_;
  size_t at_ = 0;
};

}  // namespace

PixelOutputs::PixelOutputs(const Shader& shader, const TexelShader& texels, const RenderSettings& settings)
    : shader_(shader),
      texels_(texels),
      aovs_(settings.aovs),
      mattes_(settings.mattes),
      channels_(OutputChannelCount(settings) - 4),
      object_mattes_({}, settings.matte_ranks),
      material_mattes_({}, settings.matte_ranks) {
  needs_surface_ = Has(Aov::kNormal) || Has(Aov::kAlbedo);
  needs_place_ = needs_surface_ || Has(Aov::kDepth) || Has(Aov::kPosition) || Has(Aov::kMotion) ||
                 Has(Aov::kAmbientOcclusion);
  if (mattes_.empty()) return;
  const MatteNames names = MatteNamesOf(*shader.frame().scene);
  object_mattes_ = MatteMaker(names.objects, settings.matte_ranks);
  material_mattes_ = MatteMaker(names.materials, settings.matte_ranks);
}

bool PixelOutputs::Has(Aov aov) const {
  return std::find(aovs_.begin(), aovs_.end(), aov) != aovs_.end();
}

void PixelOutputs::Require(std::vector<PrimitiveTraits>& traits) const {
  if (!needs_place_) return;
  for (PrimitiveTraits& of_primitive : traits) of_primitive.needs_position = true;
}

SeenPair PixelOutputs::Look(const PixelPair& pair, std::optional<float> openness, RenderStats& stats) const {
  const FrameScene& frame = shader_.frame();
  const FramePrimitive& primitive = frame.primitives[frame.triangles[pair.triangle].primitive];
  SeenPair seen{.weight = pair.weight,
                .object = primitive.node,
                .material = int(primitive.material - frame.scene->materials.data())};
  if (!needs_place_) return seen;

  const Barycentric at{pair.b1 / double(pair.weight), pair.b2 / double(pair.weight)};
  const double t = pair.MiddleTime();
  const V3d middle = frame.view.ViewFromRaster(PointAt(frame, pair.triangle, at, kMidShutter));
  seen.depth = -middle.z;
  seen.position = frame.view.world_position + frame.view.WorldFromView(middle);
  if (Has(Aov::kMotion)) seen.motion = MotionOf(frame, pair.triangle, at);
  if (Has(Aov::kAmbientOcclusion)) {
    seen.open = double(openness ? *openness : texels_.Shade(pair.triangle, at, t, stats).openness);
  }
  if (!needs_surface_) return seen;
  const Surface surface = shader_.SurfaceOf(pair.triangle, at, PixelFootprintAt(frame, pair.triangle, at, t));
  seen.normal = frame.view.WorldFromView(surface.normal);
  seen.albedo = surface.base_color;
  return seen;
}

void PixelOutputs::Write(std::span<SeenPair> pairs, uint64_t total, double instants, std::span<float> out,
                         RenderStats& stats) const {
  SL_CHECK(int(out.size()) == channels_);
  std::vector<std::pair<int, uint64_t>> objects, materials;
  double nearest = std::numeric_limits<double>::infinity();
  uint64_t covered = 0;
  for (const SeenPair& pair : pairs) {
    covered += pair.weight;
    objects.emplace_back(pair.object, pair.weight);
    materials.emplace_back(pair.material, pair.weight);
    if (needs_place_) nearest = std::min(nearest, pair.depth);
  }

  SeenPair sum;
  sum.open = 0;
  if (needs_place_) {
    std::sort(pairs.begin(), pairs.end(), OrderOfSums);
    for (const SeenPair& pair : pairs) {
      const auto weight = double(pair.weight);
      sum.depth += weight * pair.depth;
      sum.position += weight * pair.position;
      sum.normal += weight * pair.normal;
      sum.albedo += weight * pair.albedo;
      sum.motion += weight * pair.motion;
      sum.open += weight * pair.open;
    }
  }
  // Places and directions are means over what is covered; light and colour fade with it.
  const double of_covered = covered > 0 ? 1 / double(covered) : 0;
  const double of_all = 1 / double(total);
  Writer writer(out);
  for (const Aov aov : aovs_) {
    switch (aov) {
      case Aov::kDepth:
        writer.Put(nearest);
        writer.Put(covered > 0 ? sum.depth * of_covered : nearest);
        break;
      case Aov::kPosition:
        writer.Put(sum.position * of_covered);
        break;
      case Aov::kNormal:
        writer.Put(sum.normal * of_covered);
        break;
      case Aov::kMotion:
        writer.Put(sum.motion.x * of_covered);
        writer.Put(sum.motion.y * of_covered);
        break;
      case Aov::kAlbedo:
        writer.Put(sum.albedo * of_all);
        break;
      case Aov::kAmbientOcclusion:
        writer.Put(sum.open * of_all);
        break;
      case Aov::kSamples:
        writer.Put(double(pairs.size()));
        writer.Put(instants);
        break;
      case Aov::kObjectId:
        writer.Put(Heaviest(objects) + 1);
        break;
      case Aov::kMaterialId:
        writer.Put(Heaviest(materials) + 1);
        break;
    }
  }
  for (const Matte matte : mattes_) {
    const MatteMaker& maker = matte == Matte::kObject ? object_mattes_ : material_mattes_;
    const bool fits = maker.Write(matte == Matte::kObject ? objects : materials, total,
                                  writer.Next(size_t(maker.channels())));
    if (!fits) ++stats.matte_overflows;
  }
}

}  // namespace shutterline::engine
