#pragma once

#include <absl/container/flat_hash_map.h>

#include <cstdint>
#include <vector>

#include "common/job/render_stats.h"
#include "worker/engine/shading/texel_shader.h"
#include "worker/engine/visibility/point_colors.h"

namespace shutterline::engine {

/// The texels that a tile sees, with what their triangles have in common and, where there is a cache, the
/// ones seen last kept near: the whole cache is larger than a processor's. One a tile and thread.
class TileTexels final : public PointColors {
 public:
  /// Both must outlive it.
  TileTexels(const TexelShader& shader, RenderStats& stats) : shader_(shader), stats_(stats) {}

  bool Has(uint32_t triangle) const override { return shader_.HasTexels(triangle); }
  uint32_t Prepare(uint32_t triangle) override;
  V3f At(uint32_t prepared, double b1, double b2) override;

 private:
  struct Near {
    TexelKey key;
    bool filled = false;
    V3f radiance;
  };
  static constexpr size_t kNearLog2 = 12;  ///< 128 KiB.

  const TexelShader& shader_;
  RenderStats& stats_;
  absl::flat_hash_map<uint32_t, uint32_t> number_of_;  // By triangle of the frame.
  std::vector<TexelShader::Triangle> triangles_;
  std::vector<Near> near_;  // By hash; empty before the first is prepared.
};

}  // namespace shutterline::engine
