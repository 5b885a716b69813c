#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/job/render_settings.h"
#include "worker/engine/render/matte.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/primitive_traits.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/shading/texel_shader.h"
#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

/// What a triangle that is visible in a pixel adds to it.
struct SeenPair {
  uint64_t weight = 0;
  int object = 0, material = 0;
  double depth = 0;
  V3d position{0, 0, 0}, normal{0, 0, 0}, albedo{0, 0, 0};
  V2d motion{0, 0};
  double open = 1;  ///< Ambient occlusion: the part of the surroundings that is seen.
};

/// What a pixel holds beside its colour: the AOVs and mattes that the settings ask for, made of the weights
/// with which triangles are visible in it and, like shading, of where their points are at mid-shutter.
/// docs/formats.md says what each channel holds. Immutable, for any number of threads.
class PixelOutputs {
 public:
  /// Both shaders must outlive it.
  PixelOutputs(const Shader& shader, const TexelShader& texels, const RenderSettings& settings);

  /// Floats a pixel.
  int channels() const { return channels_; }
  bool empty() const { return channels_ == 0; }

  /// Makes resolvers tell what of visible triangles is needed.
  void Require(std::vector<PrimitiveTraits>& traits) const;

  /// What outputs need of a pair, as far as they do. `openness`: what shading has found out about it already.
  SeenPair Look(const PixelPair& pair, std::optional<float> openness, RenderStats& stats) const;

  /// A pixel whose visible triangles are `pairs`, in any order, which is changed; several may be of one
  /// triangle. `total`: the weight of the whole pixel. `instants`: the number of instants of a line, on
  /// average. Writes channels() floats.
  void Write(std::span<SeenPair> pairs, uint64_t total, double instants, std::span<float> out,
             RenderStats& stats) const;

 private:
  bool Has(Aov aov) const;

  const Shader& shader_;
  const TexelShader& texels_;
  std::vector<Aov> aovs_;
  std::vector<Matte> mattes_;
  int channels_ = 0;
  bool needs_place_ = false;    ///< Some AOV depends on where on a triangle it is seen.
  bool needs_surface_ = false;  ///< Likewise on what the material is there.
  MatteMaker object_mattes_, material_mattes_;
};

}  // namespace shutterline::engine
