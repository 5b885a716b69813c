#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/scenes/glb_scene.h"
#include "tests/scenes/png_picture.h"

/// What a material looks like from place to place, and the pictures of it that a glTF material uses.
namespace shutterline::scenes {

/// A colour as people write it, 0xRRGGBB, left in sRGB: pictures hold it so.
V3f SrgbCode(uint32_t rgb);

/// `a` where `t` is 0, `b` where it is 1; clamped.
V3f Blend(const V3f& a, const V3f& b, double t);

struct SurfacePoint {
  V3f color{0.5f, 0.5f, 0.5f};  ///< sRGB, 0 to 1; what is beyond is clamped.
  double roughness = 0.8;
  double height = 0;  ///< In sides of the picture, so that slopes do not depend on how many texels it has.
};

/// A square of points, rows from the top, that continues itself beyond its borders.
class SurfaceMap {
 public:
  /// `at` is asked at the texels' centres: u to the right, v down, both in (0, 1).
  SurfaceMap(int size, const std::function<SurfacePoint(double u, double v)>& at);

  int size() const { return size_; }
  /// Any whole numbers: wraps.
  const SurfacePoint& At(int x, int y) const;

 private:
  int size_;
  std::vector<SurfacePoint> points_;
};

PngPicture ColorPicture(const SurfaceMap& map);
/// glTF's channels: green is roughness, blue metalness, which is 0.
PngPicture RoughnessPicture(const SurfaceMap& map);
/// Tangent space normals of the heights, green up.
PngPicture NormalPicture(const SurfaceMap& map);

/// Numbers of pictures in a scene, for any number of materials.
struct SurfaceImages {
  int color = -1, roughness = -1, normal = -1;
};
SurfaceImages AddImages(GlbScene& scene, const std::string& name, const SurfaceMap& map);

/// A lit material that shows the pictures; its colour is multiplied by `tint` (linear).
int AddSurfaceMaterial(GlbScene& scene, const std::string& name, const SurfaceImages& images,
                       bool double_sided = false, const V3f& tint = V3f(1));

}  // namespace shutterline::scenes
