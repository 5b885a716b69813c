#include "worker/engine/shading/texture_lookup.h"

namespace shutterline::engine {

const MipPyramid* PyramidOf(const FrameScene& frame, const MeshPrimitive& source, const TextureRef& reference,
                            TextureEncoding encoding) {
  if (reference.texture < 0 || reference.texcoord < 0 || reference.texcoord > 1) return nullptr;
  if (source.texcoords[size_t(reference.texcoord)].empty()) return nullptr;
  return frame.Pyramid(frame.scene->textures[size_t(reference.texture)].image, encoding);
}

bool IsUsed(const FrameScene& frame, const MeshPrimitive& source, const TextureRef& reference,
            TextureEncoding encoding) {
  return PyramidOf(frame, source, reference, encoding) != nullptr;
}

void TextureLookup::Place(int coordinates) {
  placed_ = coordinates;
  const TriangleCoordinates on =
      coordinates == 0 ? triangle_.first : material_.CoordinatesOn(coordinates, triangle_.corners);
  uv_ = on.origin + at_.b1 * on.along1 + at_.b2 * on.along2;
  duv_dx_ = footprint_.db1_dx * on.along1 + footprint_.db2_dx * on.along2;
  duv_dy_ = footprint_.db1_dy * on.along1 + footprint_.db2_dy * on.along2;
}

void TextureLookup::Walk(const PreparedTexture& texture) {
  if (walked_ == texture.walk) return;
  walked_ = texture.walk;
  if (placed_ != texture.coordinates) Place(texture.coordinates);
  walk_.Make(texture.image, uv_, duv_dx_, duv_dy_, footprint_.rough ? 1 : kMostProbes);
}

V4d TextureLookup::Color(const PreparedTexture& texture) {
  if (texture.pyramid == nullptr) return V4d(1);
  Walk(texture);
  return V4d(walk_.Sample(*texture.pyramid));
}

void TextureLookup::Prefetch(const PreparedTexture& texture) {
  if (texture.pyramid == nullptr) return;
  Walk(texture);
  walk_.Prefetch(*texture.pyramid);
}

}  // namespace shutterline::engine
