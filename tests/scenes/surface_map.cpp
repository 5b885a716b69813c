#include "tests/scenes/surface_map.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace shutterline::scenes {
namespace {

uint16_t Code(double value) {
  return uint16_t(std::floor(255 * std::clamp(value, 0.0, 1.0) + 0.5));
}

/// An RGB picture whose texel (x, y) is `at(x, y)`.
template <typename At>
PngPicture Picture(int size, const At& at) {
  PngPicture picture{size, size, 3, 8, {}};
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const V3d rgb = at(x, y);
      picture.samples.insert(picture.samples.end(), {Code(rgb.x), Code(rgb.y), Code(rgb.z)});
    }
  }
  return picture;
}

}  // namespace

V3f SrgbCode(uint32_t rgb) {
  return V3f(float(rgb >> 16 & 255), float(rgb >> 8 & 255), float(rgb & 255)) / 255.0f;
}

V3f Blend(const V3f& a, const V3f& b, double t) {
  const float s = float(std::clamp(t, 0.0, 1.0));
  return a * (1 - s) + b * s;
}

SurfaceMap::SurfaceMap(int size, const std::function<SurfacePoint(double, double)>& at) : size_(size) {
  SL_CHECK(size > 0);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) points_.push_back(at((x + 0.5) / size, (y + 0.5) / size));
  }
}

const SurfacePoint& SurfaceMap::At(int x, int y) const {
  const auto wrap = [&](int i) { return size_t((i % size_ + size_) % size_); };
  return points_[wrap(y) * size_t(size_) + wrap(x)];
}

PngPicture ColorPicture(const SurfaceMap& map) {
  return Picture(map.size(), [&](int x, int y) { return V3d(map.At(x, y).color); });
}

PngPicture RoughnessPicture(const SurfaceMap& map) {
  return Picture(map.size(), [&](int x, int y) { return V3d(1, map.At(x, y).roughness, 0); });
}

PngPicture NormalPicture(const SurfaceMap& map) {
  const double to_slope = map.size() / 2.0;
  return Picture(map.size(), [&](int x, int y) {
    const double right = (map.At(x + 1, y).height - map.At(x - 1, y).height) * to_slope;
    const double down = (map.At(x, y + 1).height - map.At(x, y - 1).height) * to_slope;
    const double length = std::sqrt(right * right + down * down + 1);
    return V3d(0.5 - 0.5 * right / length, 0.5 + 0.5 * down / length, 0.5 + 0.5 / length);
  });
}

SurfaceImages AddImages(GlbScene& scene, const std::string& name, const SurfaceMap& map) {
  SurfaceImages images;
  images.color = scene.Add(Image{name, EncodePng(ColorPicture(map))});
  images.roughness = scene.Add(Image{name + " roughness", EncodePng(RoughnessPicture(map))});
  images.normal = scene.Add(Image{name + " normal", EncodePng(NormalPicture(map))});
  return images;
}

int AddSurfaceMaterial(GlbScene& scene, const std::string& name, const SurfaceImages& images,
                       bool double_sided, const V3f& tint) {
  Material material;
  material.name = name;
  material.color = tint;
  material.unlit = false;
  material.double_sided = double_sided;
  material.color_texture.image = images.color;
  material.metallic_roughness_texture.image = images.roughness;
  material.normal_texture.image = images.normal;
  return scene.Add(std::move(material));
}

}  // namespace shutterline::scenes
