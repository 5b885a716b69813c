#include "tests/scenes/texcoords.h"

#include <cmath>

#include "common/base/check.h"

namespace shutterline::scenes {

void MapSurface(Primitive& primitive, int columns, int rows,
                const std::function<V2f(double u, double v)>& map) {
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      primitive.texcoords.push_back(map(double(i) / columns, double(j) / rows));
    }
  }
  SL_CHECK(primitive.texcoords.size() == primitive.positions.size());
}

void MapByFacing(Primitive& primitive, float per_metre, const V2f& offset, bool turned) {
  SL_CHECK(primitive.normals.size() == primitive.positions.size());
  for (size_t i = primitive.texcoords.size(); i < primitive.positions.size(); ++i) {
    const V3f &p = primitive.positions[i], &n = primitive.normals[i];
    const float x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    V2f place;
    if (y >= x && y >= z) {
      place = n.y > 0 ? V2f(p.x, p.z) : V2f(p.x, -p.z);
    } else if (x >= z) {
      place = n.x > 0 ? V2f(-p.z, -p.y) : V2f(p.z, -p.y);
    } else {
      place = n.z > 0 ? V2f(p.x, -p.y) : V2f(-p.x, -p.y);
    }
    if (turned) place = V2f(place.y, -place.x);
    primitive.texcoords.push_back(offset + place * per_metre);
  }
}

void DropTexcoords(GlbScene& scene) {
  for (Mesh& mesh : scene.meshes) {
    for (Primitive& primitive : mesh.primitives) primitive.texcoords.clear();
  }
}

}  // namespace shutterline::scenes
