#include "tests/support/engine_frame.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "common/base/status_macros.h"
#include "tests/scenes/scene_generators.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"

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
    material.unlit = true;
  }
  for (Mesh& mesh : flat->meshes) {
    for (MeshPrimitive& primitive : mesh.primitives) primitive.colors.clear();
  }
  return flat;
}

absl::StatusOr<RenderedFrame> RenderFrame(std::shared_ptr<const Scene> scene, int frame,
                                          const RenderSettings& settings, int threads, int tile_size) {
  RenderedFrame result;
  auto start = std::chrono::steady_clock::now();
  SL_ASSIGN_OR_RETURN(auto frame_scene, BuildFrameScene(std::move(scene), frame, settings));
  result.times.scene_seconds = SecondsSince(start);
  result.warnings = frame_scene->warnings;

  start = std::chrono::steady_clock::now();
  SL_ASSIGN_OR_RETURN(const auto integrator, MakeTileIntegrator(frame_scene, frame, settings, threads));
  result.times.build_seconds = SecondsSince(start);

  start = std::chrono::steady_clock::now();
  result.image =
      RenderTiles(*integrator, settings.width, settings.height, tile_size, tile_size, threads, &result.stats);
  result.times.render_seconds = SecondsSince(start);
  return result;
}

absl::StatusOr<std::vector<uint8_t>> MovingRegion(std::shared_ptr<const Scene> scene, int frame,
                                                  const RenderSettings& settings, const Image& blurred,
                                                  int threads) {
  RenderSettings open = settings;
  open.shutter_close = open.shutter_open;
  RenderSettings close = settings;
  close.shutter_open = close.shutter_close;
  SL_ASSIGN_OR_RETURN(const RenderedFrame at_open, RenderFrame(scene, frame, open, threads));
  SL_ASSIGN_OR_RETURN(const RenderedFrame at_close, RenderFrame(scene, frame, close, threads));
  std::vector<uint8_t> mask;
  for (int y = 0; y < settings.height; ++y) {
    for (int x = 0; x < settings.width; ++x) {
      bool moves = false;
      for (int c = 0; c < 4; ++c) {
        const float a = at_open.image.At(x, y)[c];
        const float b = at_close.image.At(x, y)[c];
        const float m = blurred.At(x, y)[c];
        moves |= std::abs(a - b) > 1e-4f || std::abs(a - m) > 1e-4f;
      }
      mask.push_back(moves ? 1 : 0);
    }
  }
  return mask;
}

}  // namespace shutterline::engine
