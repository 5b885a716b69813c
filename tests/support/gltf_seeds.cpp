#include "tests/support/gltf_seeds.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace shutterline {
namespace {

using Json = nlohmann::json;

void AppendTo(void* out, void* data, int size) {
  static_cast<std::string*>(out)->append(static_cast<const char*>(data), size_t(size));
}

std::string Picture(bool png) {
  constexpr int kSide = 9;
  std::vector<unsigned char> rgb;
  for (int i = 0; i < kSide * kSide * 3; ++i) rgb.push_back(static_cast<unsigned char>(i * 37));
  std::string bytes;
  if (png) {
    stbi_write_png_to_func(&AppendTo, &bytes, kSide, kSide, 3, rgb.data(), 3 * kSide);
  } else {
    stbi_write_jpg_to_func(&AppendTo, &bytes, kSide, kSide, 3, rgb.data(), 70);
  }
  return bytes;
}

GltfBuilder TexturedStrip(bool png) {
  GltfBuilder file;
  const int positions =
      file.Accessor<uint16_t>("VEC4", 5123, {0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0, 9, 9, 0, 0});
  file.json["accessors"][size_t(positions)]["type"] = "VEC3";
  file.json["bufferViews"][0]["byteStride"] = 8;
  const int uv =
      file.Accessor<uint8_t>("VEC4", 5121, {0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0, 255, 255, 0, 0}, true);
  file.json["accessors"][size_t(uv)]["type"] = "VEC2";
  file.json["bufferViews"][1]["byteStride"] = 4;
  const int material = file.Add(
      "materials",
      {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 0.5, 1}}, {"baseColorTexture", {{"index", 0}}}}},
       {"emissiveTexture", {{"index", 0}, {"texCoord", 1}}},
       {"extensions", {{"KHR_materials_unlit", Json::object()}}},
       {"doubleSided", true}});
  file.Draw(file.Mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uv}, {"TEXCOORD_1", uv}}},
                       {"indices", file.Indices({0, 1, 2, 3, 3, 1})},
                       {"material", material},
                       {"mode", png ? 5 : 6}}));
  file.Add("samplers", {{"wrapS", 33071}, {"magFilter", 9728}});
  file.Add("textures", {{"source", 0}, {"sampler", 0}});
  file.Add("images",
           {{"bufferView", file.View(Picture(png))}, {"mimeType", png ? "image/png" : "image/jpeg"}});
  file.json["extensionsUsed"] = {"KHR_materials_unlit"};
  return file;
}

/// A quad with a material of all textures and factors, one with tangents and one without, and lights.
GltfBuilder ShinyAndLit() {
  GltfBuilder file;
  const int positions = file.Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  const int normals = file.Floats("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int uv = file.Floats("VEC2", {0, 1, 1, 1, 0, 0, 1, 0});
  const int tangents = file.Floats("VEC4", {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1});
  const auto texture = [](int index, const char* factor) {
    Json info = {{"index", index},
                 {"texCoord", 1},
                 {"extensions",
                  {{"KHR_texture_transform",
                    {{"offset", {0.5, -1}}, {"rotation", 1.5}, {"scale", {2, 3}}, {"texCoord", 0}}}}}};
    if (factor != nullptr) info[factor] = 0.5;
    return info;
  };
  const int material =
      file.Add("materials", {{"pbrMetallicRoughness",
                              {{"metallicFactor", 0.5},
                               {"roughnessFactor", 0.25},
                               {"baseColorTexture", texture(0, nullptr)},
                               {"metallicRoughnessTexture", texture(1, nullptr)}}},
                             {"normalTexture", texture(0, "scale")},
                             {"occlusionTexture", texture(1, "strength")},
                             {"emissiveTexture", texture(0, nullptr)},
                             {"emissiveFactor", {1, 0.5, 0}},
                             {"alphaMode", "MASK"},
                             {"alphaCutoff", 0.25},
                             {"extensions",
                              {{"KHR_materials_emissive_strength", {{"emissiveStrength", 5}}},
                               {"KHR_materials_ior", {{"ior", 1.33}}},
                               {"KHR_materials_specular",
                                {{"specularFactor", 0.5},
                                 {"specularTexture", texture(1, nullptr)},
                                 {"specularColorFactor", {0.5, 1, 2}},
                                 {"specularColorTexture", texture(0, nullptr)}}}}}});
  Json attributes = {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uv}};
  const int indices = file.Indices({0, 1, 2, 2, 1, 3});
  file.Draw(file.Mesh({{"attributes", attributes}, {"indices", indices}, {"material", material}}));
  attributes["TANGENT"] = tangents;
  file.Draw(file.Mesh({{"attributes", attributes}, {"indices", indices}, {"material", material}}));
  file.Add("textures", {{"source", 0}});
  file.Add("textures", {{"source", 1}});
  file.Add("images", {{"bufferView", file.View(Picture(true))}});
  file.Add("images", {{"bufferView", file.View(Picture(false))}});
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "directional"}, {"color", {1, 0.5, 0.25}}, {"intensity", 3}},
      {{"type", "point"}, {"range", 9}, {"name", "bulb"}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}}};
  for (size_t light = 0; light < 2; ++light) {
    file.json["nodes"][light]["extensions"]["KHR_lights_punctual"]["light"] = light + 1;
  }
  file.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_emissive_strength",
                                 "KHR_materials_ior", "KHR_materials_specular", "KHR_texture_transform"};
  file.json["extensionsRequired"] = {"KHR_texture_transform"};
  return file;
}

GltfBuilder SkinnedAndMorphed() {
  GltfBuilder file;
  const int positions = file.Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int normals = file.Accessor<int8_t>("VEC4", 5120, {0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}, true);
  file.json["accessors"][size_t(normals)]["type"] = "VEC3";
  file.json["bufferViews"][1]["byteStride"] = 4;
  const int joints = file.Accessor<uint8_t>("VEC4", 5121, {0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0});
  const int weights = file.Floats("VEC4", {.5, .5, 0, 0, 1, 0, 0, 0, .25, .75, 0, 0});
  const int node = file.Draw(file.Mesh({{"attributes",
                                         {{"POSITION", positions},
                                          {"NORMAL", normals},
                                          {"COLOR_0", positions},
                                          {"JOINTS_0", joints},
                                          {"WEIGHTS_0", weights},
                                          {"JOINTS_1", joints},
                                          {"WEIGHTS_1", weights}}},
                                        {"targets", {{{"POSITION", positions}}, {{"NORMAL", normals}}}}}));
  file.json["meshes"][0]["weights"] = {0.5, 0};
  std::vector<float> matrices(32, 0.0f);
  for (size_t i = 0; i < 32; i += 5) matrices[i] = 1;
  file.Add(
      "nodes",
      {{"children", {2}}, {"translation", {1, 2, 3}}, {"rotation", {0, 0, 0, 1}}, {"scale", {1, -1, 1}}});
  file.Add("nodes", {{"camera", 0}});
  file.json["nodes"][size_t(node)]["children"] = {1};
  file.json["nodes"][size_t(node)]["skin"] =
      file.Add("skins", {{"joints", {1, 2}}, {"inverseBindMatrices", file.Floats("MAT4", matrices)}});
  file.Add("cameras",
           {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.01}, {"zfar", 9}}}});
  file.Add("cameras", {{"type", "orthographic"},
                       {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 9}}}});
  const int times = file.Floats("SCALAR", {0, 1});
  Json animation = {{"samplers", Json::array()}, {"channels", Json::array()}};
  const auto animate = [&](int target, const char* path, const char* interpolation, int output) {
    animation["samplers"].push_back({{"input", times}, {"output", output}, {"interpolation", interpolation}});
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", target}, {"path", path}}}});
  };
  animate(1, "translation", "CUBICSPLINE", file.Floats("VEC3", std::vector<float>(18, 1.5f)));
  animate(1, "rotation", "LINEAR",
          file.Accessor<int16_t>("VEC4", 5122, {0, 0, 0, 32767, 32767, 0, 0, 0}, true));
  animate(2, "scale", "STEP", file.Floats("VEC3", {1, 1, 1, 2, 2, 2}));
  animate(0, "weights", "LINEAR", file.Floats("SCALAR", {0, 1, 2, 3}));
  file.Add("animations", animation);
  return file;
}

GltfBuilder SparseAndMatrix() {
  GltfBuilder file;
  const int positions = file.Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  const std::vector<float> moved = {5, 6, 7, 8, 9, 10};
  file.json["accessors"][size_t(positions)]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", file.View(std::string("\1\0\2\0", 4))}, {"componentType", 5123}}},
      {"values", {{"bufferView", file.View(std::string(reinterpret_cast<const char*>(moved.data()), 24))}}}};
  for (const int mode : {0, 1, 2, 3, 4}) {
    file.Draw(file.Mesh({{"attributes", {{"POSITION", positions}}}, {"mode", mode}}));
  }
  file.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 4, 5, 1};
  file.json["scene"] = 0;
  return file;
}

}  // namespace

std::vector<GltfBuilder> GltfSeeds() {
  std::vector<GltfBuilder> seeds = {TexturedStrip(true), TexturedStrip(false), SkinnedAndMorphed(),
                                    SparseAndMatrix(), ShinyAndLit()};
  for (GltfBuilder& seed : seeds) seed.json["buffers"][0] = {{"byteLength", seed.buffer.size()}};
  return seeds;
}

}  // namespace shutterline
