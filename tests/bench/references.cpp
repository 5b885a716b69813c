#include "tests/bench/references.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <system_error>

#include "common/asset/digest.h"
#include "common/base/atomic_file.h"
#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "common/math/compensated_sum.h"
#include "tests/bench/measure.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/sampling/point_pattern.h"
#include "worker/engine/shading/shade.h"

namespace shutterline::bench {
namespace {

/// Each half is the mean of so many pictures of seeds of their own, which tell the noise.
constexpr int kChunksPerHalf = 2;
/// To be changed with what a cached reference means.
constexpr const char* kVersion = "reference 2";

template <typename T>
absl::string_view Bytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Everything that the pictures follow from.
std::string CacheKey(const engine::Shader& shader, const TileSubset& subset, const std::string& what) {
  const engine::FrameScene& frame_scene = shader.frame();
  Sha256Stream hash;
  hash.Update(absl::StrCat(kVersion, ";", what, ";", frame_scene.view.width, "x", frame_scene.view.height,
                           ";", frame_scene.view.perspective, ";"));
  const double view[6] = {frame_scene.view.scale_x,  frame_scene.view.scale_y, frame_scene.view.center_x,
                          frame_scene.view.center_y, frame_scene.view.znear,   frame_scene.view.zfar};
  hash.Update({reinterpret_cast<const char*>(view), sizeof view});
  hash.Update(Bytes(frame_scene.control_points));
  hash.Update(Bytes(frame_scene.triangles));
  hash.Update(Bytes(frame_scene.normals));
  hash.Update(Bytes(subset.tiles));
  for (uint32_t i = 0; i < frame_scene.triangles.size(); i += 7) {  // Stands for materials and colours.
    const V3f color = shader.Shade(i, {0.3, 0.3}, {});
    hash.Update({reinterpret_cast<const char*>(&color), sizeof color});
  }
  for (const engine::FramePrimitive& primitive : frame_scene.primitives) {
    hash.Update(
        absl::StrCat(primitive.degree, ",", primitive.pieces, ",", primitive.material->double_sided, ";"));
  }
  return hash.Finish().ToHex();
}

std::optional<std::vector<Image>> ReadChunks(const std::string& path, const TileSubset& subset, int count) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::vector<Image> chunks;
  for (int i = 0; i < count; ++i) {
    chunks.push_back(StackedImage(subset));
    auto& values = chunks.back().values();
    file.read(reinterpret_cast<char*>(values.data()), std::streamsize(values.size() * sizeof(float)));
    if (!file) return std::nullopt;
  }
  return chunks;
}

ReferenceHalves Halves(const std::vector<Image>& chunks, int spp) {
  ReferenceHalves result{.a = chunks[0], .b = chunks[kChunksPerHalf], .spp = spp};
  CompensatedSum variance;
  for (size_t i = 0; i < result.a.values().size(); ++i) {
    double sums[2] = {0, 0}, squares = 0;
    for (size_t k = 0; k < chunks.size(); ++k) {
      const double value = double(chunks[k].values()[i]);
      sums[k / kChunksPerHalf] += value;
      squares += value * value;
    }
    result.a.values()[i] = float(sums[0] / kChunksPerHalf);
    result.b.values()[i] = float(sums[1] / kChunksPerHalf);
    if (i % 4 == 3) continue;
    const double n = double(chunks.size()), mean = (sums[0] + sums[1]) / n;
    variance.Add(std::max(0.0, squares - n * mean * mean) / (n - 1) / n);
  }
  result.noise = std::sqrt(variance.Total() / (0.75 * double(result.a.values().size())));
  return result;
}

absl::StatusOr<ReferenceHalves> Cached(const std::string& key, const TileSubset& subset, int spp,
                                       const ReferenceCache& cache,
                                       const std::function<absl::StatusOr<Image>(int chunk)>& render) {
  const std::string path = absl::StrCat(cache.folder, "/", key, ".floats");
  if (!cache.folder.empty()) {
    if (const auto chunks = ReadChunks(path, subset, 2 * kChunksPerHalf)) return Halves(*chunks, spp);
  }
  std::vector<Image> chunks;
  std::string bytes;
  for (int chunk = 0; chunk < 2 * kChunksPerHalf; ++chunk) {
    SL_ASSIGN_OR_RETURN(Image image, render(chunk));
    const absl::string_view part = Bytes(image.values());
    bytes.append(part.data(), part.size());
    chunks.push_back(std::move(image));
  }
  if (!cache.folder.empty()) {
    std::error_code error;
    std::filesystem::create_directories(cache.folder, error);
    SL_RETURN_IF_ERROR(WriteFileAtomically(path, bytes));
  }
  return Halves(chunks, spp);
}

/// Piece [step, step + 1] of a line of a tile.
struct LineStep {
  const engine::TileLine* line;
  int step;
};

/// The steps of every pixel of a tile.
std::vector<std::vector<LineStep>> StepsOf(const engine::LinePattern& pattern,
                                           const std::vector<engine::TileLine>& lines, const TileRect& rect) {
  std::vector<std::vector<LineStep>> steps(size_t(rect.Area()));
  for (const engine::TileLine& line : lines) {
    const bool major_is_x = pattern.families()[size_t(line.family)].major_is_x;
    for (int step = line.first_step; step < line.end_step; ++step) {
      const int minor = pattern.MinorPixel(line, step);
      const int x = major_is_x ? step : minor, y = major_is_x ? minor : step;
      steps[size_t(y) * size_t(rect.width) + size_t(x)].push_back({&line, step});
    }
  }
  return steps;
}

/// Sums of one pixel's hits on one triangle.
struct TriangleHits {
  uint32_t triangle;
  double hits, b1, b2, t;
};

/// The pixel's mean colour, every hit shaded on its own; added to rgba[0..3].
void ShadeHits(const PointProbe& probe, std::span<const ProbePoint> points, std::span<const ProbeHit> hits,
               float* rgba) {
  double sum[4] = {0, 0, 0, 0};
  for (size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].hit) continue;
    const V3f radiance = probe.Radiance(hits[i], points[i].t);
    for (int c = 0; c < 3; ++c) sum[c] += double(radiance[c]);
    sum[3] += 1;
  }
  for (int c = 0; c < 4; ++c) rgba[c] = float(sum[c] / double(hits.size()));
}

/// The same, every triangle shaded once.
void ShadePairs(const PointProbe& probe, std::span<const ProbePoint> points, std::span<const ProbeHit> hits,
                std::vector<TriangleHits>& pairs, float* rgba) {
  pairs.clear();
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].hit) pairs.push_back({hits[i].triangle, 1, hits[i].b1, hits[i].b2, points[i].t});
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const TriangleHits& a, const TriangleHits& b) { return a.triangle < b.triangle; });
  double sum[4] = {0, 0, 0, 0};
  for (size_t i = 0; i < pairs.size();) {
    TriangleHits mean = pairs[i];
    for (++i; i < pairs.size() && pairs[i].triangle == mean.triangle; ++i) {
      mean.hits += 1;
      mean.b1 += pairs[i].b1;
      mean.b2 += pairs[i].b2;
      mean.t += pairs[i].t;
    }
    const ProbeHit at{true, mean.triangle, mean.b1 / mean.hits, mean.b2 / mean.hits};
    const V3f radiance = probe.Radiance(at, mean.t / mean.hits);
    for (int c = 0; c < 3; ++c) sum[c] += mean.hits * double(radiance[c]);
    sum[3] += mean.hits;
  }
  for (int c = 0; c < 4; ++c) rgba[c] = float(sum[c] / double(hits.size()));
}

/// One tile of a line-restricted reference, from points of one seed: the picture of traced hits and, `offset`
/// values behind it, that of pairs.
void RenderLineTile(const PointProbe& probe, const engine::LinePattern& pattern, const TileRect& rect,
                    int spp, const std::vector<engine::PointPattern>& points_of_step, float* rgba,
                    size_t offset) {
  const std::vector<engine::TileLine> lines = pattern.LinesIn(rect);
  const auto steps = StepsOf(pattern, lines, rect);
  const int per_step = std::max(1, spp / pattern.StepsPerPixel());
  std::vector<ProbePoint> points;
  std::vector<ProbeHit> hits;
  std::vector<TriangleHits> pairs;
  for (int y = 0; y < rect.height; ++y) {
    for (int x = 0; x < rect.width; ++x, rgba += 4) {
      points.clear();
      const auto& own = steps[size_t(y) * size_t(rect.width) + size_t(x)];
      SL_CHECK(int(own.size()) == pattern.StepsPerPixel());
      for (size_t s = 0; s < own.size(); ++s) {
        const engine::PixelPoints random = points_of_step[s].Pixel(rect.x + x, rect.y + y);
        const engine::LineFamily& family = pattern.families()[size_t(own[s].line->family)];
        for (int i = 0; i < per_step; ++i) {
          const engine::PixelPoint p = random.At(uint32_t(i));
          const double major = own[s].step + p.x, minor = own[s].line->intercept + family.slope * major;
          points.push_back({rect.x + (family.major_is_x ? major : minor),
                            rect.y + (family.major_is_x ? minor : major), p.t});
        }
      }
      hits.resize(points.size());
      probe.See(points, hits);
      ShadeHits(probe, points, hits, rgba);
      ShadePairs(probe, points, hits, pairs, rgba + offset);
    }
  }
}

}  // namespace

Image ReferenceHalves::Mean() const {
  Image mean = a;
  for (size_t i = 0; i < mean.values().size(); ++i) {
    mean.values()[i] = (a.values()[i] + b.values()[i]) / 2;
  }
  return mean;
}

absl::StatusOr<ReferenceHalves> RenderReference(std::shared_ptr<const engine::FrameScene> frame_scene,
                                                int frame, const RenderSettings& settings,
                                                const TileSubset& subset, int spp, int threads,
                                                const ReferenceCache& cache) {
  SL_CHECK(spp % (2 * kChunksPerHalf) == 0);
  RenderSettings chunk_settings = settings;
  chunk_settings.integrator = IntegratorKind::kReference;
  chunk_settings.spp = spp / (2 * kChunksPerHalf);
  SL_ASSIGN_OR_RETURN(const engine::Shader shader, engine::Shader::Create(frame_scene, settings));
  const std::string key = CacheKey(shader, subset, absl::StrCat("points;", frame, ";", spp));
  return Cached(key, subset, spp, cache, [&](int chunk) {
    chunk_settings.seed = 7000001 + uint64_t(chunk);
    return RenderSubset(frame_scene, frame, chunk_settings, subset, threads);
  });
}

absl::StatusOr<LineReference> RenderLineReference(const PointProbe& probe, int frame,
                                                  const RenderSettings& settings, const TileSubset& subset,
                                                  int spp, int threads, const ReferenceCache& cache) {
  const auto& pattern = engine::LinePattern::Get(settings.pattern);
  const std::string key =
      CacheKey(probe.shader(), subset,
               absl::StrCat("lines;", std::string(ToString(settings.pattern)), ";", frame, ";", spp));
  // Both pictures are rendered at once, as one of twice the tiles.
  TileSubset both = subset;
  both.tiles.insert(both.tiles.end(), subset.tiles.begin(), subset.tiles.end());
  const size_t offset = StackedImage(subset).values().size();
  SL_ASSIGN_OR_RETURN(const ReferenceHalves halves, Cached(key, both, spp, cache, [&](int chunk) {
                        std::vector<engine::PointPattern> points;
                        for (int step = 0; step < pattern.StepsPerPixel(); ++step) {
                          points.emplace_back(8000001 + uint64_t(chunk) * 64 + uint64_t(step), frame);
                        }
                        Image stack = StackedImage(both);
                        ParallelFor(int(subset.tiles.size()), threads, [&](int index, int) {
                          RenderLineTile(probe, pattern, subset.tiles[size_t(index)],
                                         spp / (2 * kChunksPerHalf), points, stack.At(0, index * kTileSize),
                                         offset);
                        });
                        return absl::StatusOr<Image>(std::move(stack));
                      }));
  LineReference result;
  for (const auto& [from, part] : {std::pair(size_t(0), &result.traced), {offset, &result.cached}}) {
    part->spp = spp;
    part->a = part->b = StackedImage(subset);
    std::copy_n(halves.a.values().begin() + ptrdiff_t(from), offset, part->a.values().begin());
    std::copy_n(halves.b.values().begin() + ptrdiff_t(from), offset, part->b.values().begin());
  }
  return result;
}

}  // namespace shutterline::bench
