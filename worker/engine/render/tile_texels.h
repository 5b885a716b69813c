#pragma once

#include <absl/container/flat_hash_map.h>

#include <cstdint>

#include "common/job/render_stats.h"
#include "worker/engine/shading/texel_shader.h"
#include "worker/engine/visibility/point_colors.h"

namespace shutterline::engine {

/// The texels that a tile sees: their colours, with what of their triangles is the same for all of them kept.
/// One a tile and thread.
class TileTexels final : public PointColors {
 public:
  /// Both must outlive it.
  TileTexels(const TexelShader& shader, RenderStats& stats) : shader_(shader), stats_(stats) {}

  bool Has(uint32_t triangle) const override { return shader_.HasTexels(triangle); }
  V3f At(uint32_t triangle, double b1, double b2) override;

 private:
  const TexelShader& shader_;
  RenderStats& stats_;
  absl::flat_hash_map<uint32_t, TexelShader::Corners> corners_;
  // The one asked for last is mostly the next.
  bool has_last_ = false;
  uint32_t last_ = 0;
  TexelShader::Corners corners_of_last_;
};

}  // namespace shutterline::engine
