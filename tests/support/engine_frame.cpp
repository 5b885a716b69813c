#include "tests/support/engine_frame.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "common/base/status_macros.h"
#include "tests/scenes/scene_generators.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/accel/bvh.h"
#include "worker/engine/render/make_resolver.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"
#include "worker/engine/shading/shading_cache.h"
#include "worker/engine/visibility/resolver.h"
#include "worker/engine/visibility/tile_triangles.h"

namespace shutterline::engine {
namespace {

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Distinct, not too dark, the same for the same number.
V3f ColorOf(size_t number) {
  const auto part = [&](double step) { return float(0.2 + 0.8 * std::fmod(double(number + 1) * step, 1.0)); };
  return {part(0.754877), part(0.569840), part(0.430160)};
}

TileRect WindowOf(const RenderSettings& settings, const FrameOptions& options) {
  return options.window.value_or(TileRect{0, 0, settings.width, settings.height});
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Scene>> LoadTestScene(const std::string& name) {
  for (const scenes::SceneInfo& info : scenes::AllScenes()) {
    if (info.name != name) continue;
    SL_ASSIGN_OR_RETURN(std::string glb, scenes::GenerateGlb(name));
    return ImportGltf(MemoryAssetSource(name + ".glb", {{name + ".glb", std::move(glb)}}));
  }
  SL_ASSIGN_OR_RETURN(const auto source, DirectoryAssetSource::Open(name));
  return ImportGltf(*source);
}

std::shared_ptr<const Scene> WithFlatColors(const Scene& scene) {
  auto flat = std::make_shared<Scene>(scene);
  for (size_t i = 0; i < flat->materials.size(); ++i) {
    Material& material = flat->materials[i];
    const V3f color = ColorOf(i);
    material.base_color_factor = V4f(color.x, color.y, color.z, 1);
    material.base_color_texture = {};
    material.emissive_factor = V3f(0, 0, 0);
    material.emissive_texture = {};
    material.alpha_mode = AlphaMode::kOpaque;
    material.unlit = true;
  }
  for (Mesh& mesh : flat->meshes) {
    for (MeshPrimitive& primitive : mesh.primitives) primitive.colors.clear();
  }
  return flat;
}

absl::StatusOr<RenderedFrame> RenderFrame(std::shared_ptr<const Scene> scene, int frame,
                                          const RenderSettings& settings, const FrameOptions& options) {
  RenderedFrame result;
  auto start = std::chrono::steady_clock::now();
  SL_ASSIGN_OR_RETURN(auto frame_scene, BuildFrameScene(std::move(scene), frame, settings));
  result.times.scene_seconds = SecondsSince(start);
  result.warnings = frame_scene->warnings;

  start = std::chrono::steady_clock::now();
  SL_ASSIGN_OR_RETURN(auto cache, ShadingCache::Create(kDefaultShadingCacheBytes));
  SL_ASSIGN_OR_RETURN(const auto integrator,
                      MakeTileIntegrator(frame_scene, frame, settings, options.threads, std::move(cache)));
  result.times.build_seconds = SecondsSince(start);

  start = std::chrono::steady_clock::now();
  result.image = RenderWindow(*integrator, WindowOf(settings, options), options.tile_size, options.tile_size,
                              options.threads, &result.stats);
  result.times.render_seconds = SecondsSince(start);
  return result;
}

absl::StatusOr<MovingMasks> MaskMotion(std::shared_ptr<const Scene> scene, int frame,
                                       const RenderSettings& settings, const FrameOptions& options,
                                       double least_pixels) {
  RenderSettings line = settings;
  line.integrator = IntegratorKind::kLine;
  RenderSettings open = line;
  open.shutter_close = open.shutter_open;
  RenderSettings close = line;
  close.shutter_open = close.shutter_close;
  SL_ASSIGN_OR_RETURN(const RenderedFrame blurred, RenderFrame(scene, frame, line, options));
  SL_ASSIGN_OR_RETURN(const RenderedFrame at_open, RenderFrame(scene, frame, open, options));
  SL_ASSIGN_OR_RETURN(const RenderedFrame at_close, RenderFrame(scene, frame, close, options));
  MovingMasks masks;
  for (size_t i = 0; i < blurred.image.values().size(); i += 4) {
    bool changes = false;
    for (size_t c = i; c < i + 4; ++c) {
      const float a = at_open.image.values()[c];
      changes |=
          std::abs(a - at_close.image.values()[c]) > 1e-4f || std::abs(a - blurred.image.values()[c]) > 1e-4f;
    }
    masks.changed.push_back(changes ? 1 : 0);
  }

  // See what is fast.
  masks.region.resize(masks.changed.size());
  SL_ASSIGN_OR_RETURN(auto frame_scene, BuildFrameScene(std::move(scene), frame, line));
  SL_ASSIGN_OR_RETURN(const auto bvh, Bvh::Build(frame_scene, options.threads));
  const std::vector<PrimitiveTraits> traits(frame_scene->primitives.size());
  const LinePattern& pattern = LinePattern::Get(line.pattern);
  const auto resolver = MakeResolver(line);
  const TileRect window = WindowOf(settings, options);
  for (int y = 0; y < window.height; y += kTileSize) {
    for (int x = 0; x < window.width; x += kTileSize) {
      const TileRect rect{window.x + x, window.y + y, std::min(kTileSize, window.width - x),
                          std::min(kTileSize, window.height - y)};
      std::vector<uint32_t> candidates;
      bvh->CollectVisible(rect, candidates);
      TileTriangles tile;
      SetUpTile(*frame_scene, traits, pattern, rect, candidates, tile);
      std::unordered_set<uint32_t> fast;
      for (const TileTriangle& triangle : tile.triangles) {
        if (triangle.moves && triangle.motion_pixels >= least_pixels) fast.insert(triangle.id);
      }
      PairWeights weights;
      RenderStats stats;
      resolver->Resolve({*frame_scene, traits, rect, candidates}, weights, nullptr, stats);
      for (int64_t pixel = 0; pixel < rect.Area(); ++pixel) {
        bool sees_fast = false;
        weights.ForEach(pixel, [&](const PixelPair& pair) { sees_fast |= fast.contains(pair.triangle); });
        const size_t row = size_t(y) + size_t(pixel / rect.width);
        masks.region[row * size_t(window.width) + size_t(x) + size_t(pixel % rect.width)] = sees_fast ? 1 : 0;
      }
    }
  }
  for (size_t i = 0; i < masks.region.size(); ++i) masks.changed[i] &= masks.region[i];
  return masks;
}

}  // namespace shutterline::engine
