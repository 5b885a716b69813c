#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "common/job/render_settings.h"
#include "common/math/spaces.h"
#include "worker/engine/occlusion/ambient_occlusion.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/primitive_traits.h"
#include "worker/engine/shading/barycentric.h"
#include "worker/engine/shading/lighting.h"
#include "worker/engine/shading/shaded.h"
#include "worker/engine/shading/surface.h"

namespace shutterline::engine {

/// Shades the surfaces of a frame under the lights that the settings ask for. Immutable, so any number of
/// threads may use one; what it returns is a function of the frame, the settings and the arguments alone, so
/// it does not matter who evaluates it, or when.
class Shader {
 public:
  /// Builds what lights and ambient occlusion need, with up to `threads` threads.
  static absl::StatusOr<Shader> Create(std::shared_ptr<const FrameScene> frame,
                                       const RenderSettings& settings, int threads = 1);

  /// `lighting` may refer to the frame. `occlusion` may be null: then nothing hides what comes from
  /// everywhere.
  Shader(std::shared_ptr<const FrameScene> frame, Lighting lighting,
         std::shared_ptr<const AmbientOcclusion> occlusion = nullptr);
  // The prepared materials refer to the frame, which does not move.

  /// Linear radiance leaving triangle `triangle` at `at` towards the camera, lit as at mid-shutter, as if
  /// it were opaque: layers are not premultiplied.
  V3f Shade(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
    return ShadeFully(triangle, at, footprint).radiance;
  }
  /// The same with all that comes along.
  Shaded ShadeFully(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
    return ShadeUnder(occlusion_.get(), triangle, at, footprint);
  }
  /// The same for a triangle of which several points are wanted.
  Shaded ShadeFully(const SurfaceTriangle& triangle, const Barycentric& at,
                    const Footprint& footprint) const {
    if (triangle.primitive->material->unlit) return ShadeUnlit(triangle.number, at, footprint);
    return ShadeLit(occlusion_.get(), triangle, at, footprint);
  }
  SurfaceTriangle TriangleOf(uint32_t triangle) const {
    return {*frame_, materials_[frame_->triangles[triangle].primitive], triangle};
  }
  /// Radiance as if nothing occluded the surroundings: where a guess will do.
  V3f ShadeInTheOpen(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
    return ShadeUnder(nullptr, triangle, at, footprint).radiance;
  }

  /// What Shade shades.
  Surface SurfaceOf(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const;

  /// Alpha of the base colour: of factor, vertex colours and texture together. Cut-offs are not looked at.
  double Alpha(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const;

  /// True if Shade returns the same value all over every triangle of the primitive: then `at` and
  /// `footprint` are never looked at and callers need not compute them.
  bool IsConstant(const FramePrimitive& primitive) const;

  /// For methods that know nothing of layers: UNIMPLEMENTED, naming the method and the first layer's
  /// material, where the frame has any.
  absl::Status CheckOpaque(absl::string_view method) const;

  /// By primitive of the frame.
  std::vector<PrimitiveTraits> Traits() const;

  /// Whether shading a material takes long: where ambient occlusion is computed for it.
  bool IsDear(const Material& material) const { return occlusion_ != nullptr && !material.unlit; }

  /// Whether nothing but sky and ambient light, unoccluded, and the surface's own shows it.
  bool IsLitBySkyAlone(const FramePrimitive& primitive) const {
    return !primitive.material->unlit && occlusion_ == nullptr && !lighting_.head_light &&
           lighting_.lights.empty() && lighting_.HasSky();
  }
  const PreparedMaterial& MaterialOf(uint32_t primitive) const { return materials_[primitive]; }
  const Lighting& lighting() const { return lighting_; }
  const FrameScene& frame() const { return *frame_; }

 private:
  Shaded ShadeUnder(const AmbientOcclusion* occlusion, uint32_t triangle, const Barycentric& at,
                    const Footprint& footprint) const;
  Shaded ShadeUnlit(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const;
  Shaded ShadeLit(const AmbientOcclusion* occlusion, const SurfaceTriangle& triangle, const Barycentric& at,
                  const Footprint& footprint) const;
  V4d BaseColor(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const;
  bool IsGlossy(const Material& material) const;
  void MakeLayer(const FramePrimitive& primitive, PrimitiveTraits& traits) const;

  std::shared_ptr<const FrameScene> frame_;
  Lighting lighting_;
  std::shared_ptr<const AmbientOcclusion> occlusion_;
  std::vector<PreparedMaterial> materials_;  ///< By primitive.
};

}  // namespace shutterline::engine
