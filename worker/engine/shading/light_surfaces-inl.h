// Materials of a batch, and what they reflect of the sky. Included once per instruction set, by
// shade_kernels.cpp.
#if defined(SHUTTERLINE_LIGHT_SURFACES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_LIGHT_SURFACES_INL_H
#undef SHUTTERLINE_LIGHT_SURFACES_INL_H
#else
#define SHUTTERLINE_LIGHT_SURFACES_INL_H
#endif

#include <hwy/highway.h>

#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/directional_albedo.h"
#include "worker/engine/shading/lighting.h"
#include "worker/engine/shading/prepared_material.h"
#include "worker/engine/shading/shade_vectors-inl.h"
#include "worker/engine/shading/sky_lookup-inl.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Channel `c` of what is seen of a texture; 1 where it is not used.
HWY_INLINE Doubles TexelAt(const SurfaceBatch& batch, const PreparedMaterial& material, TextureSlot slot,
                           size_t c, size_t k) {
  return material.Of(slot).pyramid == nullptr ? All(1) : At(batch.texels[size_t(slot)][c], k);
}
HWY_INLINE Doubles3 TexelsAt(const SurfaceBatch& batch, const PreparedMaterial& material, TextureSlot slot,
                             size_t k) {
  const auto channel = [&](size_t c) { return TexelAt(batch, material, slot, c, k); };
  return {channel(0), channel(1), channel(2)};
}

HWY_INLINE Doubles3 MixCorners(const Doubles (&weights)[3], const Doubles3& a, const Doubles3& b,
                               const Doubles3& c) {
  const Doubles zero = hn::Zero(ShadeTag());
  return Doubles3{zero, zero, zero} + Times(weights[0], a) + Times(weights[1], b) + Times(weights[2], c);
}

/// A point's directions, as SurfaceAt places them.
struct PlacedPoints {
  Doubles3 to_camera, normal;
  DoublesMask odd;
};

/// The normal that the texture asks for.
HWY_INLINE Doubles3 BendNormals(const FramePrimitive& primitive, const PreparedMaterial& material,
                                const SurfaceBatch& batch, size_t k, const Doubles (&weights)[3],
                                const Doubles3& normal, DoublesMask& odd) {
  const Doubles zero = hn::Zero(ShadeTag()), one = All(1), two = All(2),
                scale = All(primitive.material->normal_scale);
  const Doubles3 texel = TexelsAt(batch, material, TextureSlot::kNormal, k);
  const auto centred = [&](Doubles x) { return hn::Sub(hn::Mul(two, x), one); };
  const Doubles3 bent{hn::Mul(scale, centred(texel.x)), hn::Mul(scale, centred(texel.y)), centred(texel.z)};
  Doubles3 tangent{zero, zero, zero};
  Doubles sign = zero;
  for (size_t corner = 0; corner < 3; ++corner) {
    tangent = tangent + Times(weights[corner], At3(batch.tangents, 4 * corner, k));
    sign = hn::Add(sign, hn::Mul(weights[corner], At(batch.tangents[4 * corner + 3], k)));
  }
  tangent = Unit(tangent - Times(Dot(normal, tangent), normal), odd);
  const Doubles side = hn::IfThenElse(hn::Lt(sign, zero), All(-1), one);
  const Doubles3 bitangent = Times(side, Cross(normal, tangent));
  return Unit(Times(bent.x, tangent) + Times(bent.y, bitangent) + Times(bent.z, normal), odd);
}

HWY_INLINE PlacedPoints PlacePoints(const FrameView& view, const FramePrimitive& primitive,
                                    const PreparedMaterial& material, const SurfaceBatch& batch, size_t k) {
  const Doubles zero = hn::Zero(ShadeTag());
  const Doubles b1 = At(batch.b1, k), b2 = At(batch.b2, k);
  const Doubles weights[3] = {hn::Sub(hn::Sub(All(1), b1), b2), b1, b2};
  const Doubles3 face = At3(batch.face, 0, k);
  const DoublesMask has_no_face =
      hn::And(hn::And(hn::Eq(face.x, zero), hn::Eq(face.y, zero)), hn::Eq(face.z, zero));
  PlacedPoints placed{.to_camera = All(V3d(0, 0, 1)), .normal = face, .odd = has_no_face};
  if (view.perspective) {
    const Doubles3 position =
        MixCorners(weights, At3(batch.corners, 0, k), At3(batch.corners, 3, k), At3(batch.corners, 6, k));
    placed.to_camera = Unit(Negative(position), placed.odd);
  }
  if (primitive.has_normals) {
    const Doubles3 mean =
        MixCorners(weights, At3(batch.normals, 0, k), At3(batch.normals, 3, k), At3(batch.normals, 6, k));
    placed.normal = Unit(mean, placed.odd);
  }
  placed.normal = Choose(hn::Lt(Dot(placed.normal, face), zero), Negative(placed.normal), placed.normal);
  if (primitive.has_tangents) {
    placed.normal = BendNormals(primitive, material, batch, k, weights, placed.normal, placed.odd);
  }
  const DoublesMask is_behind = hn::Lt(Dot(face, placed.to_camera), zero);
  placed.normal = Choose(is_behind, Negative(placed.normal), placed.normal);
  return placed;
}

/// GgxDirectionalAlbedo.
struct AlbedoLanes {
  Doubles scale, bias;

  AlbedoLanes(const DirectionalAlbedoTable& table, Doubles n_dot_v, Doubles roughness) {
    const ShadeTag d;
    const hn::RebindToSigned<ShadeTag> dl;
    constexpr int kSide = DirectionalAlbedoTable::kSide;
    const Doubles zero = hn::Zero(d), one = All(1), last = All(kSide - 1), last_cell = All(kSide - 2);
    const Doubles x = hn::Mul(Clamped(n_dot_v, zero, one), last);
    const Doubles y = hn::Mul(Clamped(roughness, zero, one), last);
    // Whatever a lane of no point holds stays within the table.
    const auto cell = [&](Doubles at) { return hn::Max(zero, hn::Min(hn::Floor(at), last_cell)); };
    const Doubles column = cell(x), row = cell(y);
    const Doubles fx = hn::Sub(x, column), fy = hn::Sub(y, row);
    const double* const numbers = &table.rows[0][0].scale;
    const auto first = hn::ConvertTo(dl, hn::Mul(All(2), hn::Add(hn::Mul(row, All(kSide)), column)));
    const auto look = [&](int64_t which) {
      const auto at = [&](int64_t offset) {
        return hn::GatherIndex(d, numbers, hn::Add(first, hn::Set(dl, which + 2 * offset)));
      };
      return Between(Between(at(0), at(1), fx), Between(at(kSide), at(kSide + 1), fx), fy);
    };
    scale = look(0);
    bias = look(1);
  }
};

/// Of a material, what light needs: members of Surface.
struct MaterialLanes {
  Doubles3 base_color, f0, emission;
  Doubles metallic, roughness, f90, occlusion;

  MaterialLanes(const Material& material, const PreparedMaterial& prepared, const SurfaceBatch& batch,
                size_t k) {
    const Doubles zero = hn::Zero(ShadeTag()), one = All(1);
    base_color = At3(batch.tint, 0, k) * TexelsAt(batch, prepared, TextureSlot::kBaseColor, k);
    const Doubles3 texel = TexelsAt(batch, prepared, TextureSlot::kMetallicRoughness, k);
    metallic = Clamped(hn::Mul(All(material.metallic_factor), texel.z), zero, one);
    roughness = Clamped(hn::Mul(All(material.roughness_factor), texel.y), zero, one);
    const Doubles specular =
        hn::Mul(All(material.specular_factor), TexelAt(batch, prepared, TextureSlot::kSpecular, 3, k));
    const Doubles3 tint =
        All(V3d(material.specular_color_factor)) * TexelsAt(batch, prepared, TextureSlot::kSpecularColor, k);
    const auto head_on = [&](Doubles of_tint, Doubles base) {
      const Doubles dielectric = hn::Mul(Lesser(hn::Mul(All(prepared.head_on), of_tint), one), specular);
      return hn::Add(dielectric, hn::Mul(metallic, hn::Sub(base, dielectric)));
    };
    f0 = {head_on(tint.x, base_color.x), head_on(tint.y, base_color.y), head_on(tint.z, base_color.z)};
    f90 = hn::Add(specular, hn::Mul(metallic, hn::Sub(one, specular)));
    occlusion = one;
    if (material.occlusion_texture.texture >= 0) {
      const Doubles open = TexelAt(batch, prepared, TextureSlot::kOcclusion, 0, k);
      occlusion = hn::Add(one, hn::Mul(All(material.occlusion_strength), hn::Sub(open, one)));
    }
    emission = {zero, zero, zero};
    if (material.emissive_factor != V3f(0)) {
      emission = All(V3d(material.emissive_factor)) * TexelsAt(batch, prepared, TextureSlot::kEmissive, k);
    }
  }
};

/// Of one channel, Reflect under a sky.
HWY_INLINE Doubles FromSky(const MaterialLanes& material, const AlbedoLanes& albedo, Doubles f0, Doubles base,
                           Doubles mirrored, Doubles scattered) {
  const Doubles one = All(1);
  const Doubles rest = hn::Sub(one, hn::Add(albedo.scale, albedo.bias));
  const Doubles once = hn::Add(hn::Mul(f0, albedo.scale), hn::Mul(material.f90, albedo.bias));
  const Doubles mean = hn::Add(f0, hn::Div(hn::Sub(material.f90, f0), All(21)));
  const Doubles repeatedly = hn::Div(hn::Mul(hn::Mul(once, mean), rest), hn::Sub(one, hn::Mul(rest, mean)));
  const Doubles matte =
      hn::Mul(hn::Mul(hn::Sub(one, hn::Add(once, repeatedly)), hn::Sub(one, material.metallic)), base);
  const Doubles sum =
      hn::Add(hn::Add(hn::Mul(once, mirrored), hn::Mul(repeatedly, scattered)), hn::Mul(matte, scattered));
  return hn::Mul(material.occlusion, sum);
}

inline void LightSurfacesKernel(const FrameView& view, const Lighting& lighting,
                                const FramePrimitive& primitive, const PreparedMaterial& prepared,
                                SurfaceBatch& batch) {
  const ShadeTag d;
  const ShadeFloats df;
  const DirectionalAlbedoTable& albedos = DirectionalAlbedoTable::Get();
  for (size_t k = 0; k < batch.count; k += hn::Lanes(d)) {
    PlacedPoints placed = PlacePoints(view, primitive, prepared, batch, k);
    const MaterialLanes material(*primitive.material, prepared, batch, k);
    const Doubles3& n = placed.normal;
    const Doubles n_dot_v = Greater(Dot(n, placed.to_camera), All(1e-4));
    const AlbedoLanes albedo(albedos, n_dot_v, material.roughness);
    Doubles3 scattered = All(lighting.ambient), mirrored = scattered;
    if (lighting.sky != nullptr) {
      const auto in_world = [&](const Doubles3& v) {
        return Doubles3{Dot(v, All(view.world_axes[0])), Dot(v, All(view.world_axes[1])),
                        Dot(v, All(view.world_axes[2]))};
      };
      scattered = scattered + Diffuse(*lighting.sky, in_world(n));
      const Doubles3 reflected = Unit(Times(hn::Mul(All(2), n_dot_v), n) - placed.to_camera, placed.odd);
      const Doubles alpha = hn::Mul(material.roughness, material.roughness);
      const Doubles3 lobe = Unit(reflected + Times(alpha, n - reflected), placed.odd);
      mirrored = mirrored + Glossy(*lighting.sky, in_world(lobe), material.roughness);
    }
    const auto channel = [&](Doubles f0, Doubles base, Doubles of_mirrored, Doubles of_scattered,
                             Doubles emission) {
      const Doubles reflected = FromSky(material, albedo, f0, base, of_mirrored, of_scattered);
      return hn::DemoteTo(df, hn::Add(reflected, emission));
    };
    const Doubles3 &f0 = material.f0, &base = material.base_color, &emission = material.emission;
    hn::Store(channel(f0.x, base.x, mirrored.x, scattered.x, emission.x), df, batch.radiance[0].data() + k);
    hn::Store(channel(f0.y, base.y, mirrored.y, scattered.y, emission.y), df, batch.radiance[1].data() + k);
    hn::Store(channel(f0.z, base.z, mirrored.z, scattered.z, emission.z), df, batch.radiance[2].data() + k);
    HWY_ALIGN double odd[8];
    hn::Store(hn::IfThenElseZero(placed.odd, All(1)), d, odd);
    for (size_t i = 0; i < hn::Lanes(d); ++i) batch.is_odd[k + i] = odd[i] != 0;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
