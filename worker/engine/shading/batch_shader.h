#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/shading/batch_looks.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/shading/surface_batch.h"
#include "worker/engine/shading/texel_shader.h"

namespace shutterline::engine {

/// Shades many points at a time where vectors can: on what stands still, has no texels and is lit by what
/// comes from everywhere. To the last bit as TexelShader::Shade does. Immutable and thread-safe.
class BatchShader {
 public:
  struct Point {
    uint32_t triangle = 0;  ///< In the frame.
    Barycentric at;
  };

  /// What it takes of memory, for one thread at a time.
  struct Desk {
    SurfaceBatch batch;
    BatchWalks walks;
  };

  /// Both must outlive it.
  BatchShader(const Shader& shader, const TexelShader& texels);

  /// Whether points on a primitive of the frame may be given to Shade.
  bool Takes(uint32_t primitive) const { return takes_[primitive]; }

  /// At most SurfaceBatch::kMost points on one primitive; as many radiances.
  void Shade(uint32_t primitive, std::span<const Point> points, TexelShader::Lately& lately, Desk& desk,
             std::span<V3f> radiance) const;

 private:
  void Add(const SurfaceTriangle& triangle, const Barycentric& at, SurfaceBatch& batch) const;
  void SampleTextures(const PreparedMaterial& material, std::span<const Point> points,
                      TexelShader::Lately& lately, Desk& desk) const;
  void SampleAlong(const PreparedMaterial& material, const PreparedTexture& first, Desk& desk) const;

  const Shader& shader_;
  const TexelShader& texels_;
  std::vector<bool> takes_;  // By primitive.
};

}  // namespace shutterline::engine
