#include "worker/engine/shading/sky_map.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <mutex>

#include "common/base/work_limit.h"
#include "common/math/unit_vector.h"
#include "worker/engine/shading/ggx.h"
#include "worker/engine/shading/half_vectors.h"
#include "worker/engine/shading/quick_angle.h"

namespace shutterline::engine {
namespace {

constexpr int kSkySamples = 128;
/// Lobes of these are stored; between them radiance is mixed.
constexpr double kRoughnesses[] = {0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0};

/// Real spherical harmonics up to the second degree.
std::array<double, 9> Harmonics(const V3d& d) {
  return {0.28209479177387814,
          0.4886025119029199 * d.y,
          0.4886025119029199 * d.z,
          0.4886025119029199 * d.x,
          1.0925484305920792 * d.x * d.y,
          1.0925484305920792 * d.y * d.z,
          0.31539156525252005 * (3 * d.z * d.z - 1),
          1.0925484305920792 * d.x * d.z,
          0.5462742152960396 * (d.x * d.x - d.y * d.y)};
}

/// What the cosine lobe, over π, leaves of a harmonic of each degree.
constexpr double kCosineLobe[] = {1.0, 2.0 / 3, 0.25};
constexpr int kDegree[] = {0, 1, 1, 1, 2, 2, 2, 2, 2};

double RowSolidAngle(int y, int width, int height) {
  return 2 * M_PI / width * (std::cos(M_PI * y / height) - std::cos(M_PI * (y + 1) / height));
}

}  // namespace

SkyMap::Level SkyMap::Level::OfSize(int width, double roughness) {
  Level level;
  level.width = width;
  level.height = width / 2;
  level.roughness = roughness;
  level.texels.assign(size_t(level.width) * size_t(level.height) + 1, V3f(0));
  return level;
}

V3d SkyMap::Level::DirectionOf(int x, int y) const {
  const double longitude = 2 * M_PI * (x + 0.5) / width;
  const double latitude = M_PI * (y + 0.5) / height;
  return {std::sin(latitude) * std::sin(longitude), std::cos(latitude),
          -std::sin(latitude) * std::cos(longitude)};
}

V2d SkyMap::Level::AnglesOf(const V3d& direction) {
  const double longitude = QuickAngle(direction.x, -direction.z) / (2 * M_PI);
  const double level = std::sqrt(direction.x * direction.x + direction.z * direction.z);
  return {longitude < 0 ? longitude + 1 : longitude, QuickAngle(level, direction.y) / M_PI};
}

V3d SkyMap::Level::At(const V2d& angles) const {
  // Both are at least -1/2: what is cut off is what lies above the integer.
  const double x = angles.x * width + (width - 0.5), y = angles.y * height + 0.5;
  const int column = int(x), row = int(y);
  const auto fx = float(x - column), fy = float(y - row);
  int x0 = column;
  while (x0 >= width) x0 -= width;  // Once or twice: no division is as quick.
  const int x1 = x0 + 1 < width ? x0 + 1 : 0;
  const int y0 = std::max(row - 1, 0), y1 = std::min(row, height - 1);
  const Float4 upper = Mix(Padded(x0, y0), Padded(x1, y0), fx);
  const Float4 lower = Mix(Padded(x0, y1), Padded(x1, y1), fx);
  const Float4 mixed = Mix(upper, lower, fy);
  return {mixed[0], mixed[1], mixed[2]};
}

Float4 SkyMap::Level::Padded(int x, int y) const {
  Float4 texel;
  std::memcpy(&texel, reinterpret_cast<const char*>(texels.data()) + sizeof(V3f) * IndexOf(x, y),
              sizeof(texel));
  return texel;
}

std::shared_ptr<const SkyMap> SkyMap::Uniform(const V3d& radiance) {
  std::shared_ptr<SkyMap> sky(new SkyMap);
  sky->uniform_ = radiance;
  return sky;
}

std::shared_ptr<const SkyMap> SkyMap::Make(const Radiance& radiance, int width) {
  std::shared_ptr<SkyMap> sky(new SkyMap);
  Level sharp = Level::OfSize(std::max(width, 8), 0);
  tbb::parallel_for(0, sharp.height, [&](int y) {
    for (int x = 0; x < sharp.width; ++x) {
      sharp.texels[sharp.IndexOf(x, y)] = V3f(radiance(sharp.DirectionOf(x, y)));
    }
  });
  sky->ProjectToHarmonics(sharp);

  std::vector<Level> sources = {sharp};
  while (sources.back().width > 16) sources.push_back(Halved(sources.back()));
  sky->levels_.push_back(std::move(sharp));
  for (const double roughness : kRoughnesses) {
    // Some texels across a lobe, which is about 2 α wide.
    const int across = 4 * int(1 / (roughness * roughness));
    const int finest = sky->levels_.front().width;
    sky->levels_.push_back(
        Filtered(sources, std::clamp(across, std::min(32, finest), std::min(128, finest)), roughness));
  }
  return sky;
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
  Level picture = Level::OfSize(environment->width, 0);
  std::copy(environment->texels.begin(), environment->texels.end(), picture.texels.begin());
  // As many texels as a power of two, at most two of the picture's in a row for one: sampling takes their
  // mean.
  constexpr int kWidest = 4096;
  const int width = std::min(int(std::bit_floor(unsigned(environment->width))), kWidest);
  sky_of_last = Make([&](const V3d& direction) { return picture.Sample(direction); }, width);
  last = environment;
  return sky_of_last;
}

void SkyMap::ProjectToHarmonics(const Level& sharp) {
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

SkyMap::Level SkyMap::Halved(const Level& fine) {
  Level half = Level::OfSize(fine.width / 2, 0);
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      half.texels[half.IndexOf(x, y)] = 0.25f * (fine.At(2 * x, 2 * y) + fine.At(2 * x + 1, 2 * y) +
                                                 fine.At(2 * x, 2 * y + 1) + fine.At(2 * x + 1, 2 * y + 1));
    }
  }
  return half;
}

SkyMap::Level SkyMap::Filtered(const std::vector<Level>& sources, int width, double roughness) {
  Level level = Level::OfSize(width, roughness);
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
      angles.push_back(Level::AnglesOf(s.light.x * tangent + s.light.y * bitangent + s.light.z * normal));
    }
    for (int x = 0; x < level.width; ++x) {
      const double turn = double(x) / level.width;
      V3d sum(0);
      for (size_t i = 0; i < samples.size(); ++i) {
        const V2d at(angles[i].x + turn, angles[i].y);
        sum += samples[i].weight * sources[samples[i].source].At(at);
      }
      level.texels[level.IndexOf(x, y)] = V3f(sum / total);
    }
  });
  return level;
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
  while (i + 2 < levels_.size() && levels_[i + 1].roughness < roughness) ++i;
  const double part = std::clamp(
      (roughness - levels_[i].roughness) / (levels_[i + 1].roughness - levels_[i].roughness), 0.0, 1.0);
  const V2d angles = Level::AnglesOf(direction);
  const V3d sharper = levels_[i].At(angles);
  if (part == 0) return sharper;
  return sharper + part * (levels_[i + 1].At(angles) - sharper);
}

}  // namespace shutterline::engine
