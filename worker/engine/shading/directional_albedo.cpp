#include "worker/engine/shading/directional_albedo.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "worker/engine/shading/ggx.h"
#include "worker/engine/shading/half_vectors.h"

namespace shutterline::engine {
namespace {

constexpr int kSide = DirectionalAlbedoTable::kSide;
constexpr int kSamples = 256;

DirectionalAlbedoTable MakeTable() {
  DirectionalAlbedoTable table;
  const auto make_row = [&](int r) {
    for (int v = 0; v < kSide; ++v) {
      table.rows[size_t(r)][size_t(v)] =
          IntegrateDirectionalAlbedo(v / double(kSide - 1), r / double(kSide - 1), kSamples);
    }
  };
  // Isolated: while it waits, a thread must not take up work that wants the table; and work around it that is
  // called off must not leave the table half made.
  tbb::task_group_context own(tbb::task_group_context::isolated);
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(0, kSide, make_row, own); });
  return table;
}

DirectionalAlbedo Mix(const DirectionalAlbedo& a, const DirectionalAlbedo& b, double part) {
  return {a.scale + part * (b.scale - a.scale), a.bias + part * (b.bias - a.bias)};
}

}  // namespace

DirectionalAlbedo IntegrateDirectionalAlbedo(double n_dot_v, double roughness, int samples) {
  n_dot_v = std::max(n_dot_v, 1e-3);
  const double alpha = std::max(roughness * roughness, kLeastAlpha);
  const V3d view(std::sqrt(1 - n_dot_v * n_dot_v), 0, n_dot_v);
  // Smith's Λ for a direction of this cosine.
  const auto lambda = [&](double cosine) {
    return 0.5 * (std::sqrt(1 + alpha * alpha * (1 / (cosine * cosine) - 1)) - 1);
  };
  DirectionalAlbedo sum{0, 0};
  for (int i = 0; i < samples; ++i) {
    const V3d half = VisibleHalfVector(HammersleyPoint(i, samples), alpha, view);
    const double v_dot_h = view.dot(half);
    const double n_dot_l = 2 * v_dot_h * half.z - view.z;
    if (!(n_dot_l > 0) || !(v_dot_h > 0)) continue;
    // Of the facets that are seen, those that the light sees too.
    const double weight = (1 + lambda(n_dot_v)) / (1 + lambda(n_dot_v) + lambda(n_dot_l));
    const double grazing = std::pow(1 - v_dot_h, 5);
    sum.scale += weight * (1 - grazing);
    sum.bias += weight * grazing;
  }
  return {sum.scale / samples, sum.bias / samples};
}

const DirectionalAlbedoTable& DirectionalAlbedoTable::Get() {
  static const DirectionalAlbedoTable table = MakeTable();
  return table;
}

DirectionalAlbedo GgxDirectionalAlbedo(double n_dot_v, double roughness) {
  const DirectionalAlbedoTable& table = DirectionalAlbedoTable::Get();
  const double x = std::clamp(n_dot_v, 0.0, 1.0) * (kSide - 1);
  const double y = std::clamp(roughness, 0.0, 1.0) * (kSide - 1);
  const auto i = size_t(std::min(int(x), kSide - 2)), j = size_t(std::min(int(y), kSide - 2));
  const double fx = x - double(i);
  return Mix(Mix(table.rows[j][i], table.rows[j][i + 1], fx),
             Mix(table.rows[j + 1][i], table.rows[j + 1][i + 1], fx), y - double(j));
}

}  // namespace shutterline::engine
