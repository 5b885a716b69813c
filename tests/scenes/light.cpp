#include "tests/scenes/light.h"

#include <algorithm>

#include "common/base/check.h"

namespace shutterline::scenes {

V3f BakedColor(const V3f& color, const V3f& normal) {
  const V3f sun = V3f(-0.45f, 0.75f, 0.5f).normalized();
  const float direct = std::max(0.0f, normal.dot(sun));
  const float sky = 0.5f + 0.5f * normal.y;
  return color * (0.12f + 0.23f * sky + 0.65f * direct);
}

void BakeLight(Primitive& primitive, const V3f& color) {
  SL_CHECK(primitive.normals.size() == primitive.positions.size());
  for (const V3f& normal : primitive.normals) primitive.colors.push_back(BakedColor(color, normal));
  primitive.normals.clear();
}

}  // namespace shutterline::scenes
