#pragma once

#include <span>
#include <vector>

#include "common/job/render_stats.h"
#include "worker/engine/scene/primitive_traits.h"
#include "worker/engine/shading/batch_shader.h"
#include "worker/engine/shading/texel_shader.h"
#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

/// Shades the pairs of tiles, each once, at the mean of where it is seen. Immutable and thread-safe.
class PairShader {
 public:
  /// All must outlive it. `traits` are by primitive.
  PairShader(const Shader& shader, const TexelShader& texels, std::span<const PrimitiveTraits> traits)
      : shader_(shader), texels_(texels), batches_(shader, texels), traits_(traits) {}

  /// Of pairs by number; the first is nobody's.
  std::vector<Shaded> ShadeAll(const PairWeights& pairs, RenderStats& stats) const;

 private:
  class Waiting;

  const Shader& shader_;
  const TexelShader& texels_;
  BatchShader batches_;
  std::span<const PrimitiveTraits> traits_;
};

}  // namespace shutterline::engine
