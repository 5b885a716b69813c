#include "worker/engine/scene/gltf_schema_tables.h"

namespace shutterline::engine {
namespace {

using K = GltfKind;
constexpr bool kRequired = true;

// Small makers keep the tables below readable: name, what it is, whether it must be there.
GltfField Index(const char* name, const char* target, bool required = false) {
  return {name, K::kIndex, required, target};
}
GltfField Indices(const char* name, const char* target, bool required = false) {
  return {name, K::kIndexList, required, target};
}
GltfField Size(const char* name, bool required = false) {
  return {name, K::kSize, required};
}
GltfField Int(const char* name, std::vector<int> codes = {}, bool required = false) {
  return {name, K::kInt, required, nullptr, 0, std::move(codes)};
}
GltfField Number(const char* name, bool required = false) {
  return {name, K::kNumber, required};
}
GltfField Numbers(const char* name, size_t length) {
  return {name, K::kNumberList, false, nullptr, length};
}
GltfField String(const char* name, bool required = false) {
  return {name, K::kString, required};
}
GltfField Word(const char* name, std::vector<absl::string_view> words, bool required = false) {
  return {name, K::kWord, required, nullptr, 0, {}, std::move(words)};
}
GltfField Object(const char* name, const GltfShape* shape, bool required = false) {
  return {name, K::kObject, required, nullptr, 0, {}, {}, shape};
}
GltfField Objects(const char* name, const GltfShape* shape, bool required = false) {
  return {name, K::kObjectList, required, nullptr, 0, {}, {}, shape};
}
GltfField Presence(const char* name) {
  return {name, K::kPresence};
}

/// A shape that lives for ever, so that others may point at it.
const GltfShape* Shape(GltfShape fields) {
  return new GltfShape(std::move(fields));
}

GltfShape With(GltfShape fields, GltfField another) {
  fields.push_back(std::move(another));
  return fields;
}

GltfShape Build() {
  const auto* asset = Shape({String("version", kRequired), String("minVersion")});
  const auto* buffer = Shape({String("uri"), Size("byteLength", kRequired), String("name")});
  const auto* buffer_view = Shape({Index("buffer", "buffers", kRequired), Size("byteOffset"),
                                   Size("byteLength", kRequired), Size("byteStride"), String("name")});
  const std::vector<int> component_types = {5120, 5121, 5122, 5123, 5125, 5126};
  const auto* sparse_indices = Shape({Index("bufferView", "bufferViews", kRequired), Int("byteOffset"),
                                      Int("componentType", {5121, 5123, 5125}, kRequired)});
  const auto* sparse_values = Shape({Index("bufferView", "bufferViews", kRequired), Int("byteOffset")});
  const auto* sparse = Shape({Int("count", {}, kRequired), Object("indices", sparse_indices, kRequired),
                              Object("values", sparse_values, kRequired)});
  const auto* accessor =
      Shape({Index("bufferView", "bufferViews"), Size("byteOffset"),
             Int("componentType", component_types, kRequired), GltfField{"normalized", K::kBool},
             Size("count", kRequired),
             Word("type", {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"}, kRequired),
             Object("sparse", sparse), String("name")});

  const auto* primitive =
      Shape({GltfField{"attributes", K::kIndexMap, kRequired, "accessors"}, Index("indices", "accessors"),
             Index("material", "materials"), Int("mode", {0, 1, 2, 3, 4, 5, 6}),
             GltfField{"targets", K::kIndexMaps, false, "accessors"}});
  const auto* mesh =
      Shape({Objects("primitives", primitive, kRequired), Numbers("weights", 0), String("name")});

  const auto* placed_light = Shape({Index("light", "extensions/KHR_lights_punctual/lights", kRequired)});
  const auto* node_extensions = Shape({Object("KHR_lights_punctual", placed_light)});
  const auto* node = Shape({Index("camera", "cameras"), Indices("children", "nodes"), Index("skin", "skins"),
                            Numbers("matrix", 16), Index("mesh", "meshes"), Numbers("rotation", 4),
                            Numbers("scale", 3), Numbers("translation", 3), Numbers("weights", 0),
                            Object("extensions", node_extensions), String("name")});
  const auto* scene = Shape({Indices("nodes", "nodes"), String("name")});
  const auto* skin = Shape({Index("inverseBindMatrices", "accessors"), Index("skeleton", "nodes"),
                            Indices("joints", "nodes", kRequired), String("name")});

  const auto* perspective =
      Shape({Number("aspectRatio"), Number("yfov", kRequired), Number("zfar"), Number("znear", kRequired)});
  const auto* orthographic = Shape({Number("xmag", kRequired), Number("ymag", kRequired),
                                    Number("zfar", kRequired), Number("znear", kRequired)});
  const auto* camera = Shape({Object("orthographic", orthographic), Object("perspective", perspective),
                              Word("type", {"perspective", "orthographic"}, kRequired), String("name")});

  const auto* target = Shape({Index("node", "nodes"), String("path", kRequired)});
  // `sampler` names one of the animation's own samplers: checked with the animation, as its array is not
  // one of the document's.
  const auto* channel = Shape({Int("sampler", {}, kRequired), Object("target", target, kRequired)});
  const auto* animation_sampler =
      Shape({Index("input", "accessors", kRequired), Word("interpolation", {"LINEAR", "STEP", "CUBICSPLINE"}),
             Index("output", "accessors", kRequired)});
  const auto* animation = Shape({Objects("channels", channel, kRequired),
                                 Objects("samplers", animation_sampler, kRequired), String("name")});

  const auto* image =
      Shape({String("uri"), String("mimeType"), Index("bufferView", "bufferViews"), String("name")});
  const auto* sampler =
      Shape({Int("magFilter", {9728, 9729}), Int("minFilter", {9728, 9729, 9984, 9985, 9986, 9987}),
             Int("wrapS", {33071, 33648, 10497}), Int("wrapT", {33071, 33648, 10497}), String("name")});
  const auto* texture = Shape({Index("sampler", "samplers"), Index("source", "images"), String("name")});
  const auto* transform =
      Shape({Numbers("offset", 2), Number("rotation"), Numbers("scale", 2), Int("texCoord")});
  const auto* texture_extensions = Shape({Object("KHR_texture_transform", transform)});
  const GltfShape texture_use = {Index("index", "textures", kRequired), Int("texCoord"),
                                 Object("extensions", texture_extensions)};
  const auto* texture_info = Shape(texture_use);
  const auto* normal_info = Shape(With(texture_use, Number("scale")));
  const auto* occlusion_info = Shape(With(texture_use, Number("strength")));
  const auto* roughness = Shape({Numbers("baseColorFactor", 4), Object("baseColorTexture", texture_info),
                                 Number("metallicFactor"), Number("roughnessFactor"),
                                 Object("metallicRoughnessTexture", texture_info)});
  const auto* emissive_strength = Shape({Number("emissiveStrength")});
  const auto* ior = Shape({Number("ior")});
  const auto* specular =
      Shape({Number("specularFactor"), Object("specularTexture", texture_info),
             Numbers("specularColorFactor", 3), Object("specularColorTexture", texture_info)});
  const auto* material_extensions =
      Shape({Presence("KHR_materials_unlit"), Object("KHR_materials_emissive_strength", emissive_strength),
             Object("KHR_materials_ior", ior), Object("KHR_materials_specular", specular)});
  const auto* material = Shape(
      {Object("pbrMetallicRoughness", roughness), Object("normalTexture", normal_info),
       Object("occlusionTexture", occlusion_info), Object("emissiveTexture", texture_info),
       Numbers("emissiveFactor", 3), Word("alphaMode", {"OPAQUE", "MASK", "BLEND"}), Number("alphaCutoff"),
       GltfField{"doubleSided", K::kBool}, Object("extensions", material_extensions), String("name")});

  const auto* spot = Shape({Number("innerConeAngle"), Number("outerConeAngle")});
  const auto* light = Shape({Numbers("color", 3), Number("intensity"),
                             Word("type", {"directional", "point", "spot"}, kRequired), Number("range"),
                             Object("spot", spot), String("name")});
  const auto* lights = Shape({Objects("lights", light, kRequired)});
  const auto* extensions = Shape({Object("KHR_lights_punctual", lights)});

  return {Object("asset", asset, kRequired),
          GltfField{"extensionsRequired", K::kStringList},
          Objects("buffers", buffer),
          Objects("bufferViews", buffer_view),
          Objects("accessors", accessor),
          Objects("images", image),
          Objects("samplers", sampler),
          Objects("textures", texture),
          Objects("materials", material),
          Objects("meshes", mesh),
          Objects("skins", skin),
          Objects("cameras", camera),
          Objects("nodes", node),
          Objects("animations", animation),
          Objects("scenes", scene),
          Index("scene", "scenes"),
          Object("extensions", extensions)};
}

}  // namespace

const GltfShape& GltfRootShape() {
  static const GltfShape& shape = *new GltfShape(Build());
  return shape;
}

}  // namespace shutterline::engine
