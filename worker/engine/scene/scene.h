#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/environment.h"
#include "worker/engine/scene/mip_pyramid.h"
#include "worker/engine/scene/shared_facts.h"

/// A scene as a glTF 2.0 file describes it: plain arrays joined by indices, with all keys of all
/// animations. Immutable once imported, so any number of threads may read it; what a frame needs of it
/// is made by `BuildFrameScene` (frame_scene.h).
///
/// Lengths are metres, angles radians, times seconds, colours linear (textures: as encoded in the file,
/// sRGB). An index of -1 means "none". After import every index is in range, every array has the length
/// that its count says and every number is finite, except where a field says otherwise.
namespace shutterline::engine {

/// How a material moves its texture coordinates (KHR_texture_transform): they are scaled, turned about the
/// origin and moved, in this order:
///
///   u' = offset.x + cos(rotation) scale.x u + sin(rotation) scale.y v
///   v' = offset.y - sin(rotation) scale.x u + cos(rotation) scale.y v
///
/// With v downwards, as glTF has it, a positive angle turns coordinates counter-clockwise, hence the image on
/// the surface clockwise. That is what the extension's words and example say; the signs in its listing
/// differ.
struct TextureTransform {
  V2d offset{0, 0};
  double rotation = 0;  ///< Radians.
  V2d scale{1, 1};

  bool IsIdentity() const { return offset == V2d(0, 0) && rotation == 0 && scale == V2d(1, 1); }
};

/// A texture as a material names it.
struct TextureRef {
  int texture = -1;  ///< Index into Scene::textures.
  int texcoord = 0;  ///< Which texture coordinate set: 0 or 1.
  TextureTransform transform;
};

enum class AlphaMode : uint8_t { kOpaque, kMask, kBlend };

/// glTF's metallic-roughness model with KHR_materials_ior, _specular, _emissive_strength and _unlit. Every
/// texture multiplies its factor.
struct Material {
  std::string name;
  V4f base_color_factor{1, 1, 1, 1};  ///< Linear; the last is alpha.
  TextureRef base_color_texture;      ///< sRGB, linear alpha.
  float metallic_factor = 1;
  float roughness_factor = 1;
  TextureRef metallic_roughness_texture;  ///< Roughness in green, metallic in blue.
  TextureRef normal_texture;              ///< Tangent space, 0.5 is zero.
  float normal_scale = 1;                 ///< Of the texture's x and y.
  TextureRef occlusion_texture;           ///< In red.
  float occlusion_strength = 1;
  V3f emissive_factor{0, 0, 0};  ///< Times KHR_materials_emissive_strength: may exceed 1.
  TextureRef emissive_texture;   ///< sRGB.
  float ior = 1.5f;              ///< 1 or more; 0 stands for infinity.
  float specular_factor = 1;
  TextureRef specular_texture;  ///< In alpha.
  V3f specular_color_factor{1, 1, 1};
  TextureRef specular_color_texture;  ///< sRGB.
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;  ///< kMask: what has less is not there.
  bool unlit = false;         ///< KHR_materials_unlit.
  bool double_sided = false;  ///< False: triangles seen from behind are culled.
};

/// KHR_lights_punctual. A light shines from its node's origin along the node's -z axis.
struct PunctualLight {
  enum class Kind : uint8_t { kDirectional, kPoint, kSpot };
  std::string name;
  Kind kind = Kind::kPoint;
  V3f color{1, 1, 1};                             ///< Linear.
  float intensity = 1;                            ///< Lux for directional lights, else candela.
  float range = 0;                                ///< Metres at which the light has faded out; 0: infinite.
  float inner_cone = 0, outer_cone = 0.7853982f;  ///< Spot: angles from the axis, radians.
};

enum class WrapMode : uint8_t { kRepeat, kClampToEdge, kMirroredRepeat };

struct Texture {
  int image = -1;
  WrapMode wrap_s = WrapMode::kRepeat, wrap_t = WrapMode::kRepeat;
  bool nearest = false;  ///< The sampler asks for nearest magnification.
};

/// RGBA, rows from the top, encoded as the material that uses it says: sRGB or linear colour, linear alpha.
/// One of the arrays is empty, according to the bits a channel of the file.
struct TextureImage {
  std::string name;
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;
  std::vector<uint16_t> rgba16;
};

/// Offsets that a morph weight of 1 adds. Each array is empty or has one entry a vertex.
struct MorphTarget {
  std::vector<V3f> positions;
  std::vector<V3f> normals;
};

/// Up to 8 joints a vertex (JOINTS_0 and JOINTS_1). Weights are as in the file, normalised to sum 1;
/// joints index the skin's joints, not nodes, and are checked against the skins that use the mesh.
struct VertexInfluences {
  std::array<uint16_t, 8> joints{};
  std::array<float, 8> weights{};
};

/// Triangles that share a material. Strips and fans have been cut into triangles with glTF's winding.
/// Vertices that are not finite stay in `positions`; triangles that use them are not in `triangles`.
struct MeshPrimitive {
  std::vector<V3f> positions;  ///< Object space.
  std::vector<V3f> normals;    ///< Empty, or one a position.
  /// Directions of growing u of the normal texture, and in w the sign of the bitangent, cross(normal,
  /// tangent) times it, which points to falling v (up in the picture). Three a triangle, in the order of its
  /// corners: neighbours that share a vertex may disagree on the sign. Empty where no normal texture is used.
  std::vector<V4f> tangents;
  std::array<std::vector<V2f>, 2> texcoords;  ///< Each empty, or one a position.
  std::vector<V4f> colors;                    ///< COLOR_0, linear: empty, or one a position.
  std::vector<VertexInfluences> influences;   ///< Empty, or one a position.
  std::vector<MorphTarget> targets;
  std::vector<std::array<uint32_t, 3>> triangles;  ///< Counter-clockwise seen from the front.
  int material = 0;                                ///< Always valid: the default material is appended.
};

struct Mesh {
  std::string name;
  std::vector<MeshPrimitive> primitives;  ///< Those with triangles.
  std::vector<float> weights;             ///< Default morph weights, one a target.
};

/// A node's own transform: translation, rotation and scale, or a matrix where the file has one (matrix
/// nodes are not animated). Row-vector convention, see spaces.h.
struct NodeTransform {
  bool has_matrix = false;
  M44d matrix;
  V3d translation{0, 0, 0};
  Quatd rotation;  ///< Unit.
  V3d scale{1, 1, 1};
};

struct Node {
  std::string name;
  int parent = -1;
  std::vector<int> children;
  NodeTransform transform;
  int mesh = -1, skin = -1, camera = -1, light = -1;
  std::vector<float> weights;  ///< Morph weights that override the mesh's; empty: the mesh's.
};

struct Skin {
  std::string name;
  std::vector<int> joints;                  ///< Nodes.
  std::vector<M44d> inverse_bind_matrices;  ///< One a joint.
};

enum class Interpolation : uint8_t { kStep, kLinear, kCubicSpline };
enum class AnimatedPath : uint8_t { kTranslation, kRotation, kScale, kWeights };

/// Keys of one animated property: `values` holds `width` floats a key, or 3 × `width` (in-tangent,
/// value, out-tangent) where interpolation is kCubicSpline. Times increase strictly; at least one key.
struct AnimationChannel {
  int node = -1;
  AnimatedPath path = AnimatedPath::kTranslation;
  Interpolation interpolation = Interpolation::kLinear;
  int width = 3;  ///< 3, 4 (rotation) or the number of morph targets.
  std::vector<float> times;
  std::vector<float> values;
};

struct Animation {
  std::string name;
  std::vector<AnimationChannel> channels;
};

struct Camera {
  std::string name;
  bool perspective = true;
  double yfov = 0.8;          ///< Perspective: vertical field of view, radians.
  double aspect_ratio = 0;    ///< Perspective: width / height; 0: the frame's.
  double xmag = 1, ymag = 1;  ///< Orthographic: half the width and half the height of the view, metres.
  double znear = 0.1;
  double zfar = 0;  ///< 0: infinite (perspective only).
};

/// What the importer met and did not take, for people: each line names element and reason.
struct ImportReport {
  std::vector<std::string> warnings;
  int64_t skipped_points = 0;     ///< Point primitives' vertices.
  int64_t skipped_lines = 0;      ///< Line segments.
  int64_t dropped_triangles = 0;  ///< With a vertex that is not finite.
  int64_t stored_triangles = 0;   ///< Triangles stored, shared ones counted once.
};

struct Scene {
  std::string name;        ///< The root file's name.
  std::vector<int> roots;  ///< Nodes of the default scene.
  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<Material> materials;  ///< The last one is glTF's default material.
  std::vector<Texture> textures;
  std::vector<TextureImage> images;
  std::vector<Skin> skins;
  std::vector<Camera> cameras;
  std::vector<PunctualLight> lights;
  std::shared_ptr<const Environment> environment;  ///< Null: none.
  std::vector<Animation> animations;
  ImportReport report;
  MipPyramidCache mip_pyramids;  ///< Of `images`; made when a frame first needs them.
  SharedFacts facts;             ///< Of `meshes` and animations, likewise.
};

}  // namespace shutterline::engine
