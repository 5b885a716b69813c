#include "worker/engine/shading/batch_shader.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/base/check.h"
#include "worker/engine/shading/shade_kernels.h"

namespace shutterline::engine {
namespace {

void PutCoordinates(const TriangleCoordinates& on, size_t i, SurfaceBatch& batch) {
  size_t component = 0;
  for (const V2d& v : {on.origin, on.along1, on.along2}) {
    batch.coordinates[component++][i] = v.x;
    batch.coordinates[component++][i] = v.y;
  }
}

}  // namespace

BatchShader::BatchShader(const Shader& shader, const TexelShader& texels) : shader_(shader), texels_(texels) {
  const FrameScene& frame = shader.frame();
  for (uint32_t i = 0; i < frame.primitives.size(); ++i) {
    const FramePrimitive& primitive = frame.primitives[i];
    takes_.push_back(primitive.degree == 0 && !texels.HasTexelsOn(i) && shader.IsLitBySkyAlone(primitive));
  }
}

void BatchShader::Add(const SurfaceTriangle& triangle, const Barycentric& at, SurfaceBatch& batch) const {
  const FrameScene& frame = shader_.frame();
  const FramePrimitive& primitive = *triangle.primitive;
  const size_t i = batch.count++;
  batch.b1[i] = at.b1;
  batch.b2[i] = at.b2;
  const V4d tint = TintAt(primitive, triangle.textured.corners, at);
  for (size_t c = 0; c < 3; ++c) {
    batch.tint[c][i] = tint[int(c)];
    batch.face[c][i] = triangle.face[int(c)];
  }
  for (size_t corner = 0; corner < 3; ++corner) {
    const RasterPoint& raster = triangle.raster[corner];
    batch.raster[3 * corner][i] = raster.x;
    batch.raster[3 * corner + 1][i] = raster.y;
    batch.raster[3 * corner + 2][i] = raster.w;
    for (size_t c = 0; c < 3; ++c) batch.corners[3 * corner + c][i] = triangle.corners[corner][int(c)];
    if (!primitive.has_normals) continue;
    const V3f& normal = frame.normals[primitive.first_normal + triangle.textured.corners[corner]];
    for (size_t c = 0; c < 3; ++c) batch.normals[3 * corner + c][i] = normal[int(c)];
  }
  PutCoordinates(triangle.textured.first, i, batch);
  if (!primitive.has_tangents) return;
  const size_t first = triangle.FirstTangent();
  for (size_t corner = 0; corner < 3; ++corner) {
    const V4f& tangent = frame.tangents[first + corner];
    for (size_t c = 0; c < 4; ++c) batch.tangents[4 * corner + c][i] = tangent[int(c)];
  }
}

void BatchShader::SampleTextures(const PreparedMaterial& material, std::span<const Point> points,
                                 TexelShader::Lately& lately, Desk& desk) const {
  SurfaceBatch& batch = desk.batch;
  MeasureFootprints(batch);
  int placed = 0;  // Add has put in the first coordinates.
  uint32_t walked = 0;
  for (size_t slot = 0; slot < kTextureSlots; ++slot) {
    const PreparedTexture& texture = material.Of(TextureSlot(slot));
    if (texture.pyramid == nullptr || (walked >> texture.walk & 1) != 0) continue;
    walked |= uint32_t{1} << texture.walk;
    if (texture.coordinates != placed) {
      placed = texture.coordinates;
      for (size_t i = 0; i < points.size(); ++i) {
        const TexturedTriangle& triangle = lately.Of(points[i].triangle).textured;
        PutCoordinates(placed == 0 ? triangle.first : material.CoordinatesOn(placed, triangle.corners), i,
                       batch);
      }
    }
    SampleAlong(material, texture, desk);
  }
}

void BatchShader::SampleAlong(const PreparedMaterial& material, const PreparedTexture& first,
                              Desk& desk) const {
  SurfaceBatch& batch = desk.batch;
  std::array<LookedAt, kTextureSlots> looked_at;
  std::array<std::pair<size_t, size_t>, kTextureSlots> copies;  // From slot, to slot.
  size_t count = 0, copy_count = 0;
  for (size_t slot = 0; slot < kTextureSlots; ++slot) {
    const PreparedTexture& texture = material.Of(TextureSlot(slot));
    if (texture.pyramid == nullptr || texture.walk != first.walk) continue;
    // Occlusion mostly shares its image with roughness.
    const auto same = std::find_if(looked_at.begin(), looked_at.begin() + count,
                                   [&](const LookedAt& of) { return of.pyramid == texture.pyramid; });
    if (same != looked_at.begin() + count) {
      copies[copy_count++] = {same->slot, slot};
    } else {
      looked_at[count++] = {texture.pyramid, slot};
    }
  }
  PlanWalks(first.image, kMostProbes, batch);
  PlaceLooks(first.image, batch, desk.walks);
  SumLooks({looked_at.data(), count}, desk.walks, batch);
  for (size_t i = 0; i < copy_count; ++i) batch.texels[copies[i].second] = batch.texels[copies[i].first];
}

void BatchShader::Shade(uint32_t primitive, std::span<const Point> points, TexelShader::Lately& lately,
                        Desk& desk, std::span<V3f> radiance) const {
  SL_CHECK(points.size() <= SurfaceBatch::kMost && radiance.size() == points.size());
  SurfaceBatch& batch = desk.batch;
  batch.count = 0;
  for (const Point& point : points) Add(lately.Of(point.triangle), point.at, batch);
  const PreparedMaterial& material = shader_.MaterialOf(primitive);
  if (texels_.IsTexturedOn(primitive)) SampleTextures(material, points, lately, desk);
  LightSurfaces(shader_.frame().view, shader_.lighting(), shader_.frame().primitives[primitive], material,
                batch);
  for (size_t i = 0; i < points.size(); ++i) {
    if (batch.is_odd[i]) {
      radiance[i] = texels_.ShadeStill(lately.Of(points[i].triangle), points[i].at).radiance;
    } else {
      radiance[i] = {batch.radiance[0][i], batch.radiance[1][i], batch.radiance[2][i]};
    }
  }
}

}  // namespace shutterline::engine
