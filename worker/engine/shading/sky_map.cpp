#include "worker/engine/shading/sky_map.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <mutex>

#include "common/base/work_limit.h"
#include "common/math/unit_vector.h"
#include "worker/engine/shading/ggx.h"
#include "worker/engine/shading/half_vectors.h"

namespace shutterline::engine {
namespace {

constexpr int kSkySamples = 128;
/// Lobes of these are stored; between them radiance is mixed.
constexpr double kRoughnesses[] = {0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0};

/// What the cosine lobe, over π, leaves of a harmonic of each degree.
constexpr double kCosineLobe[] = {1.0, 2.0 / 3, 0.25};
constexpr int kDegree[] = {0, 1, 1, 1, 2, 2, 2, 2, 2};

/// By the lobe of this roughness, from maps each half of the one before.
LatLongMap Filtered(const std::vector<LatLongMap>& sources, int width, double roughness) {
  LatLongMap level = LatLongMap::OfSize(width);
  const double alpha = roughness * roughness;
  // Light directions about +z under the lobe, and the source map whose texels are as large as what a sample
  // stands for [krivanek2008].
  struct Sample {
    V3d light;
    double weight;
    size_t source;
  };
  std::vector<Sample> samples;
  double total = 0;
  const double texel = 2 * M_PI * M_PI / (double(sources[0].width) * sources[0].height);
  for (int i = 0; i < kSkySamples; ++i) {
    const V3d half = VisibleHalfVector(HammersleyPoint(i, kSkySamples), alpha, V3d(0, 0, 1));
    const V3d light(2 * half.z * half.x, 2 * half.z * half.y, 2 * half.z * half.z - 1);
    if (!(light.z > 0)) continue;
    const double density = GgxDistribution(half.z, alpha) / 4;
    const double lod = 0.5 * std::log2(1 / (kSkySamples * density) / texel) + 1;
    const auto source = size_t(std::clamp(std::lround(lod), 0l, long(sources.size()) - 1));
    samples.push_back({light, light.z, source});
    total += light.z;
  }
  tbb::parallel_for(0, level.height, [&](int y) {
    // A lobe turned about the axis looks the same in another column: its directions are found once a row.
    const V3d normal = level.DirectionOf(0, y);
    const V3d tangent = UnitOrZero(V3d(0, 1, 0).cross(normal));  // No texel's middle lies on the axis.
    const V3d bitangent = normal.cross(tangent);
    std::vector<V2d> angles;
    for (const Sample& s : samples) {
      angles.push_back(LatLongOf(s.light.x * tangent + s.light.y * bitangent + s.light.z * normal));
    }
    for (int x = 0; x < level.width; ++x) {
      const double turn = double(x) / level.width;
      V3d sum(0);
      for (size_t i = 0; i < samples.size(); ++i) {
        const V2d at(angles[i].x + turn, angles[i].y);
        sum += samples[i].weight * sources[samples[i].source].SampleAt(at);
      }
      level.texels[level.IndexOf(x, y)] = V3f(sum / total);
    }
  });
  return level;
}

double RowSolidAngle(int y, int width, int height) {
  return 2 * M_PI / width * (std::cos(M_PI * y / height) - std::cos(M_PI * (y + 1) / height));
}

}  // namespace

std::shared_ptr<const SkyMap> SkyMap::Uniform(const V3d& radiance) {
  std::shared_ptr<SkyMap> sky(new SkyMap);
  sky->uniform_ = radiance;
  return sky;
}

std::shared_ptr<const SkyMap> SkyMap::Make(const Radiance& radiance, int width) {
  std::shared_ptr<SkyMap> sky(new SkyMap);
  LatLongMap sharp = LatLongMap::OfSize(std::max(width, 8));
  tbb::parallel_for(0, sharp.height, [&](int y) {
    for (int x = 0; x < sharp.width; ++x) {
      sharp.texels[sharp.IndexOf(x, y)] = V3f(radiance(sharp.DirectionOf(x, y)));
    }
  });
  sky->ProjectToHarmonics(sharp);

  const int finest = sharp.width;
  std::vector<LatLongMap> sources = {std::move(sharp)};
  while (sources.back().width > 16) sources.push_back(LatLongMap::Halved(sources.back()));
  std::vector<LatLongMap> rougher;
  for (const double roughness : kRoughnesses) {
    // Some texels across a lobe, which is about 2 α wide.
    const int across = 4 * int(1 / (roughness * roughness));
    rougher.push_back(
        Filtered(sources, std::clamp(across, std::min(32, finest), std::min(128, finest)), roughness));
  }
  sky->Append(std::move(sources.front()), 0);
  size_t more = 0;
  for (const LatLongMap& map : rougher) more += map.texels.size();
  sky->texels_.reserve(sky->texels_.size() + more);  // And no more than that: the sharp map may be large.
  for (size_t i = 0; i < rougher.size(); ++i) sky->Append(std::move(rougher[i]), kRoughnesses[i]);
  return sky;
}

void SkyMap::Append(LatLongMap map, double roughness) {
  // The last texel of a map is the spare one.
  if (!texels_.empty()) texels_.pop_back();
  maps_.push_back({map.width, map.height, roughness, texels_.size()});
  if (texels_.empty()) {
    texels_ = std::move(map.texels);
  } else {
    texels_.insert(texels_.end(), map.texels.begin(), map.texels.end());
  }
}

std::shared_ptr<const SkyMap> SkyMap::Of(const std::shared_ptr<const Environment>& environment) {
  static std::mutex mutex;
  static std::weak_ptr<const Environment> last;
  static std::shared_ptr<const SkyMap> sky_of_last;
  std::unique_lock<std::mutex> lock(mutex, std::defer_lock);
  {
    const WorkPause others;  // Who makes the sky of another job is not this one's time.
    lock.lock();
  }
  if (last.lock() == environment && sky_of_last != nullptr) return sky_of_last;
  LatLongMap picture = LatLongMap::OfSize(environment->width);
  std::copy(environment->texels.begin(), environment->texels.end(), picture.texels.begin());
  // As many texels as a power of two, at most two of the picture's in a row for one: sampling takes their
  // mean.
  constexpr int kWidest = 4096;
  const int width = std::min(int(std::bit_floor(unsigned(environment->width))), kWidest);
  sky_of_last = Make([&](const V3d& direction) { return picture.Sample(direction); }, width);
  last = environment;
  return sky_of_last;
}

void SkyMap::ProjectToHarmonics(const LatLongMap& sharp) {
  harmonics_.fill(V3d(0));
  for (int y = 0; y < sharp.height; ++y) {
    const double solid_angle = RowSolidAngle(y, sharp.width, sharp.height);
    for (int x = 0; x < sharp.width; ++x) {
      const std::array<double, 9> basis = Harmonics(sharp.DirectionOf(x, y));
      for (size_t i = 0; i < basis.size(); ++i) {
        harmonics_[i] += (basis[i] * solid_angle) * V3d(sharp.At(x, y));
      }
    }
  }
  for (size_t i = 0; i < harmonics_.size(); ++i) harmonics_[i] *= kCosineLobe[kDegree[i]];
}

V3d SkyMap::Diffuse(const V3d& normal) const {
  if (is_uniform()) return uniform_;
  const std::array<double, 9> basis = Harmonics(normal);
  V3d sum(0);
  for (size_t i = 0; i < basis.size(); ++i) sum += basis[i] * harmonics_[i];
  // Harmonics ring: behind a bright light they may fall below zero.
  return {std::max(sum.x, 0.0), std::max(sum.y, 0.0), std::max(sum.z, 0.0)};
}

V3d SkyMap::Glossy(const V3d& direction, double roughness) const {
  if (is_uniform()) return uniform_;
  size_t i = 0;
  while (i + 2 < maps_.size() && maps_[i + 1].roughness < roughness) ++i;
  const Map &sharp = maps_[i], &rough = maps_[i + 1];
  const double part =
      std::clamp((roughness - sharp.roughness) / (rough.roughness - sharp.roughness), 0.0, 1.0);
  const V2d angles = LatLongOf(direction);
  const V3d sharper = SampleAt(sharp, angles);
  if (part == 0) return sharper;
  return sharper + part * (SampleAt(rough, angles) - sharper);
}

}  // namespace shutterline::engine
