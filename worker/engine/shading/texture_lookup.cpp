#include "worker/engine/shading/texture_lookup.h"

#include "worker/engine/shading/texture_transform.h"

namespace shutterline::engine {
namespace {

bool AreEqual(const TextureTransform& a, const TextureTransform& b) {
  return a.offset == b.offset && a.rotation == b.rotation && a.scale == b.scale;
}

/// Null where the texture is not used.
const MipPyramid* PyramidOf(const FrameScene& frame, const MeshPrimitive& source, const TextureRef& reference,
                            TextureEncoding encoding) {
  if (reference.texture < 0 || reference.texcoord < 0 || reference.texcoord > 1) return nullptr;
  if (source.texcoords[size_t(reference.texcoord)].empty()) return nullptr;
  return frame.Pyramid(frame.scene->textures[size_t(reference.texture)].image, encoding);
}

}  // namespace

bool IsUsed(const FrameScene& frame, const MeshPrimitive& source, const TextureRef& reference,
            TextureEncoding encoding) {
  return PyramidOf(frame, source, reference, encoding) != nullptr;
}

void TextureLookup::Place(const TextureRef& reference) {
  if (texcoord_ == reference.texcoord && AreEqual(transform_, reference.transform)) return;
  texcoord_ = reference.texcoord;
  transform_ = reference.transform;
  walked_ = {};
  const std::vector<V2f>& coordinates = source_.texcoords[size_t(texcoord_)];
  const V2d uv0(coordinates[corners_[0]]);
  V2d along1 = V2d(coordinates[corners_[1]]) - uv0;
  V2d along2 = V2d(coordinates[corners_[2]]) - uv0;
  uv_ = uv0 + weights_[1] * along1 + weights_[2] * along2;
  if (!transform_.IsIdentity()) {
    const TurnAndScale turned(transform_);
    uv_ = transform_.offset + turned(uv_);
    along1 = turned(along1);
    along2 = turned(along2);
  }
  duv_dx_ = footprint_.db1_dx * along1 + footprint_.db2_dx * along2;
  duv_dy_ = footprint_.db1_dy * along1 + footprint_.db2_dy * along2;
}

const MipPyramid* TextureLookup::Walk(const TextureRef& reference, TextureEncoding encoding) {
  const MipPyramid* pyramid = PyramidOf(frame_, source_, reference, encoding);
  if (pyramid == nullptr) return nullptr;
  Place(reference);
  const WalkedImage image(*pyramid, frame_.scene->textures[size_t(reference.texture)]);
  if (image != walked_) {
    walk_.Make(image, uv_, duv_dx_, duv_dy_, footprint_.rough ? 1 : kMostProbes);
    walked_ = image;
  }
  return pyramid;
}

V4d TextureLookup::Color(const TextureRef& reference, TextureEncoding encoding) {
  const MipPyramid* pyramid = Walk(reference, encoding);
  return pyramid == nullptr ? V4d(1) : V4d(walk_.Sample(*pyramid));
}

void TextureLookup::Prefetch(const TextureRef& reference, TextureEncoding encoding) {
  const MipPyramid* pyramid = Walk(reference, encoding);
  if (pyramid != nullptr) walk_.Prefetch(*pyramid);
}

}  // namespace shutterline::engine
