#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <tuple>

#include "tests/engine/scene_import/import_helpers.h"
#include "tests/scenes/png_picture.h"
#include "worker/engine/scene/material_textures.h"

namespace shutterline::engine::material_test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

std::string Png(int width, int height, const std::vector<uint8_t>& rgba) {
  return scenes::EncodePng({width, height, 4, 8, {rgba.begin(), rgba.end()}});
}

/// A triangle whose material 0 has a base colour texture from this image.
GltfBuilder Textured(const std::string& image) {
  GltfBuilder file;
  file.DrawTriangle();
  file.json["meshes"][0]["primitives"][0]["material"] = file.Add(
      "materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}, {"texCoord", 1}}}}}});
  file.Add("textures", {{"source", 0}});
  file.Add("images", {{"bufferView", file.View(image)}, {"name", "wood"}});
  return file;
}

TEST(GltfMaterial, ReadsFactorsFlagsAndUnlit) {
  GltfBuilder file;
  file.DrawTriangle();
  file.Add("materials",
           {{"name", "lamp"},
            {"doubleSided", true},
            {"emissiveFactor", {1, 2, 3}},
            {"extensions", {{"KHR_materials_unlit", json::object()}, {"VENDOR_x", 7}}},
            {"pbrMetallicRoughness", {{"baseColorFactor", {.1, .2, .3, .4}}, {"metallicFactor", 1}}}});
  file.Add("materials", json::object());
  const auto scene = MustImport(file);
  ASSERT_EQ(scene->materials.size(), 3u);
  const Material& lamp = scene->materials[0];
  EXPECT_EQ(lamp.name, "lamp");
  EXPECT_TRUE(lamp.unlit);
  EXPECT_TRUE(lamp.double_sided);
  EXPECT_EQ(lamp.emissive_factor, V3f(1, 2, 3));
  EXPECT_EQ(lamp.base_color_factor, V4f(.1f, .2f, .3f, .4f));
  EXPECT_FALSE(scene->materials[1].unlit);
  EXPECT_EQ(scene->materials[1].base_color_factor, V4f(1, 1, 1, 1));
  EXPECT_EQ(scene->materials[1].base_color_texture.texture, -1);
}

TEST(GltfMaterial, ReadsTexturesSamplersAndPixels) {
  const std::vector<uint8_t> pixels = {255, 0, 0, 255, 0, 128, 0, 64, 1, 2, 3, 4, 9, 8, 7, 6};
  GltfBuilder file = Textured(Png(2, 2, pixels));
  file.json["textures"][0]["sampler"] =
      file.Add("samplers", {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}});
  // A picture that nothing reads is not looked at, and neither is what an unlit material does not show.
  file.Add("images", {{"uri", "other.webp"}});
  const int other = file.Add("textures", {{"source", 1}});
  file.Add("materials", {{"normalTexture", {{"index", other}}},
                         {"emissiveTexture", {{"index", other}}},
                         {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  file.json["materials"][0]["emissiveTexture"] = {{"index", 0}};
  const auto scene = MustImport(file);
  ASSERT_EQ(scene->images.size(), 1u);
  EXPECT_EQ(scene->images[0].name, "wood");
  EXPECT_EQ(scene->images[0].width, 2);
  EXPECT_EQ(scene->images[0].rgba, pixels);
  ASSERT_EQ(scene->textures.size(), 1u);
  EXPECT_EQ(scene->textures[0].wrap_s, WrapMode::kClampToEdge);
  EXPECT_EQ(scene->textures[0].wrap_t, WrapMode::kMirroredRepeat);
  EXPECT_TRUE(scene->textures[0].nearest);
  const Material& material = scene->materials[0];
  EXPECT_EQ(material.base_color_texture.texture, 0);
  EXPECT_EQ(material.base_color_texture.texcoord, 1);
  EXPECT_EQ(material.emissive_texture.texture, 0);
  EXPECT_EQ(material.emissive_texture.texcoord, 0);
}

TEST(GltfMaterial, ReadsImagesFromDataUrisAndFiles) {
  const std::string png = Png(1, 1, {1, 2, 3, 4});
  GltfBuilder file = Textured("");
  for (const std::string& uri :
       {"data:image/png;base64," + GltfBuilder::Base64(png), std::string("a%20b.png")}) {
    file.json["images"][0] = {{"uri", uri}};
    const auto scene = ImportGltf(MemoryAssetSource("s.glb", {{"s.glb", file.Glb()}, {"a b.png", png}}));
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_THAT((*scene)->images[0].rgba, ElementsAre(1, 2, 3, 4));
  }
  const auto missing = ImportGltf(MemoryAssetSource("s.glb", {{"s.glb", file.Glb()}}));
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(missing.status().message(), HasSubstr("image 0: file a b.png"));
}

TEST(GltfMaterial, APictureMayBeginWithAnEmptyPieceOfData) {
  std::string png = Png(1, 1, {1, 2, 3, 4});
  const size_t data = png.find("IDAT") - 4;
  png.insert(data, std::string("\0\0\0\0IDAT\x35\xAF\x06\x1E", 12));
  const auto scene = ImportBytes(Textured(png).Glb());
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_THAT((*scene)->images[0].rgba, ElementsAre(1, 2, 3, 4));
}

TEST(GltfMaterial, RefusesImagesThatCannotBeDecoded) {
  EXPECT_THAT(MustFail(Textured("GIF89a...")).message(),
              HasSubstr("image 0 (wood): it is neither PNG nor JPEG"));
  const std::string png = Png(64, 64, std::vector<uint8_t>(64 * 64 * 4, 7));
  EXPECT_THAT(MustFail(Textured(png.substr(0, png.size() / 2))).message(), HasSubstr("image 0 (wood)"));
  GltfBuilder file = Textured(png);
  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 2;
  EXPECT_EQ(MustFail(file).code(), absl::StatusCode::kUnimplemented);
}

TEST(GltfMaterial, HoldsImagesAgainstLimitsBeforeTheyAreDecoded) {
  const GltfBuilder file = Textured(Png(64, 32, std::vector<uint8_t>(64 * 32 * 4, 7)));
  ImportLimits limits;
  limits.max_image_side = 63;
  EXPECT_THAT(MustFail(file, limits).message(), HasSubstr("image 0 (wood): 64 × 32 pixels"));
  limits = {};
  limits.max_texture_pixels = 64 * 32 - 1;
  EXPECT_EQ(MustFail(file, limits).code(), absl::StatusCode::kResourceExhausted);
  limits.max_texture_pixels = 64 * 32;
  EXPECT_TRUE(ImportBytes(file.Glb(), limits).ok());
}

TEST(GltfMaterial, AFewBytesDoNotUnfoldIntoManyPixels) {
  const std::string png = Png(64, 32, std::vector<uint8_t>(64 * 32 * 4, 7));
  const GltfBuilder file = Textured(png);
  ImportLimits limits;
  limits.base_texture_pixels = 0;
  limits.texture_pixels_per_byte = 64 * 32 / png.size();  // Rounded down: too few.
  EXPECT_THAT(MustFail(file, limits).message(), HasSubstr("64 × 32: 2048 pixels"));
  limits.texture_pixels_per_byte += 1;
  EXPECT_TRUE(ImportBytes(file.Glb(), limits).ok());
}

TEST(GltfMaterial, RefusesJpegTablesOfTooManyCodes) {
  // A JPEG that begins with a segment of metadata, which may hold what looks like a table, and one table
  // of 16 × `codes` codes.
  const auto jpeg = [](char codes) {
    std::string bytes("\xFF\xD8\xFF\xE1\x00\x06\xFF\xC4\xFF\xFF\xFF\xC4\x01\x13\x00", 15);
    return bytes + std::string(16, codes) + std::string(256, '\1');
  };
  EXPECT_THAT(MustFail(Textured(jpeg(17))).message(),
              HasSubstr("image 0 (wood): its Huffman table at byte 14 has 272"));
  EXPECT_THAT(MustFail(Textured(jpeg(16))).message(), HasSubstr("header cannot be read"));
}

TEST(GltfMaterial, RefusesAHeaderThatPromisesMoreThanItsBytesCanHold) {
  std::string png = Png(1, 1, {1, 2, 3, 4});
  png[16 + 2] = 0x40;  // Width and height, big-endian, become 16,384.
  png[20 + 2] = 0x40;
  png[16 + 3] = png[20 + 3] = 0;
  EXPECT_THAT(MustFail(Textured(png)).message(), HasSubstr("cannot hold 16384 × 16384 pixels"));
}

/// A triangle with this material and `textures` textures of one picture.
GltfBuilder WithMaterial(const json& material, int textures = 0) {
  GltfBuilder file;
  file.DrawTriangle();
  file.Add("materials", material);
  if (textures > 0) file.Add("images", {{"bufferView", file.View(Png(1, 1, {1, 2, 3, 4}))}});
  for (int i = 0; i < textures; ++i) file.Add("textures", {{"source", 0}});
  return file;
}

TEST(GltfMaterial, HasTheDefaultsOfTheSpecification) {
  const auto scene = MustImport(WithMaterial(json::object()));
  for (const Material& material : scene->materials) {
    EXPECT_EQ(material.metallic_factor, 1);
    EXPECT_EQ(material.roughness_factor, 1);
    EXPECT_EQ(material.normal_scale, 1);
    EXPECT_EQ(material.occlusion_strength, 1);
    EXPECT_EQ(material.emissive_factor, V3f(0));
    EXPECT_EQ(material.ior, 1.5f);
    EXPECT_EQ(material.specular_factor, 1);
    EXPECT_EQ(material.specular_color_factor, V3f(1));
    EXPECT_EQ(material.alpha_mode, AlphaMode::kOpaque);
    EXPECT_EQ(material.alpha_cutoff, 0.5f);
    EXPECT_FALSE(material.unlit);
    EXPECT_FALSE(material.double_sided);
    EXPECT_THAT(TexturesOf(material), testing::IsEmpty());
  }
}

TEST(GltfMaterial, ReadsEveryFactorAndEveryTexture) {
  GltfBuilder file = WithMaterial({{"pbrMetallicRoughness",
                                    {{"metallicFactor", 0.25},
                                     {"roughnessFactor", 0.75},
                                     {"baseColorTexture", {{"index", 0}}},
                                     {"metallicRoughnessTexture", {{"index", 1}, {"texCoord", 1}}}}},
                                   {"normalTexture", {{"index", 2}, {"scale", -2}}},
                                   {"occlusionTexture", {{"index", 3}, {"texCoord", 1}, {"strength", 0.125}}},
                                   {"emissiveTexture", {{"index", 4}}},
                                   {"emissiveFactor", {1, 0.5, 0}},
                                   {"alphaMode", "MASK"},
                                   {"alphaCutoff", 2},
                                   {"extensions",
                                    {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}},
                                     {"KHR_materials_ior", {{"ior", 2}}},
                                     {"KHR_materials_specular",
                                      {{"specularFactor", 0.5},
                                       {"specularTexture", {{"index", 5}, {"texCoord", 1}}},
                                       {"specularColorFactor", {0.25, 1, 4}},
                                       {"specularColorTexture", {{"index", 6}}}}}}}},
                                  7);
  file.json["extensionsRequired"] = {"KHR_materials_emissive_strength", "KHR_materials_ior",
                                     "KHR_materials_specular"};
  const auto scene = MustImport(file);
  EXPECT_THAT(scene->report.warnings, testing::IsEmpty());
  const Material& material = scene->materials[0];
  EXPECT_EQ(material.metallic_factor, 0.25f);
  EXPECT_EQ(material.roughness_factor, 0.75f);
  EXPECT_EQ(material.normal_scale, -2);
  EXPECT_EQ(material.occlusion_strength, 0.125f);
  EXPECT_EQ(material.emissive_factor, V3f(8, 4, 0));
  EXPECT_EQ(material.ior, 2);
  EXPECT_EQ(material.specular_factor, 0.5f);
  EXPECT_EQ(material.specular_color_factor, V3f(0.25f, 1, 4));
  EXPECT_EQ(material.alpha_mode, AlphaMode::kMask);
  EXPECT_EQ(material.alpha_cutoff, 2);
  EXPECT_EQ(scene->images.size(), 1u);
  // Textures are numbered as they are met.
  const std::vector<std::pair<TextureRef, int>> uses = {
      {material.base_color_texture, 0}, {material.metallic_roughness_texture, 1},
      {material.normal_texture, 0},     {material.occlusion_texture, 1},
      {material.specular_texture, 1},   {material.specular_color_texture, 0},
      {material.emissive_texture, 0}};
  for (size_t i = 0; i < uses.size(); ++i) {
    EXPECT_EQ(uses[i].first.texture, int(i));
    EXPECT_EQ(uses[i].first.texcoord, uses[i].second) << i;
    EXPECT_TRUE(uses[i].first.transform.IsIdentity());
  }
  EXPECT_EQ(TexturesOf(material).size(), 7u);

  file.json["materials"][0]["alphaMode"] = "BLEND";
  EXPECT_EQ(MustImport(file)->materials[0].alpha_mode, AlphaMode::kBlend);
  file.json["materials"][0]["extensions"]["KHR_materials_ior"]["ior"] = 0;
  EXPECT_EQ(MustImport(file)->materials[0].ior, 0);
}

TEST(GltfMaterial, ReadsTextureTransforms) {
  const json info = {{"index", 0},
                     {"texCoord", 2},  // Not supported, but what the transform says counts.
                     {"extensions",
                      {{"KHR_texture_transform",
                        {{"offset", {1, -2.5}}, {"rotation", 3}, {"scale", {2, 0.5}}, {"texCoord", 1}}}}}};
  GltfBuilder file = WithMaterial(
      {{"pbrMetallicRoughness", {{"baseColorTexture", info}, {"metallicRoughnessTexture", info}}},
       {"normalTexture", info},
       {"occlusionTexture", info},
       {"emissiveTexture", info},
       {"extensions",
        {{"KHR_materials_specular", {{"specularTexture", info}, {"specularColorTexture", info}}}}}},
      1);
  file.json["extensionsRequired"] = {"KHR_texture_transform"};
  const auto scene = MustImport(file);
  EXPECT_EQ(TexturesOf(scene->materials[0]).size(), 7u);
  for (const MaterialTexture& texture : TexturesOf(scene->materials[0])) {
    SCOPED_TRACE(texture.role);
    EXPECT_EQ(texture.reference->texcoord, 1);
    EXPECT_EQ(texture.reference->transform.offset, V2d(1, -2.5));
    EXPECT_EQ(texture.reference->transform.rotation, 3);
    EXPECT_EQ(texture.reference->transform.scale, V2d(2, 0.5));
  }
  json& transform = file.json["materials"][0]["normalTexture"]["extensions"]["KHR_texture_transform"];
  transform["texCoord"] = 2;
  const absl::Status status = MustFail(file);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented);
  EXPECT_THAT(status.message(), HasSubstr("material 0: normalTexture: texCoord 2"));
}

TEST(GltfMaterial, WrongPropertiesAreNamed) {
  const json::json_pointer pbr("/pbrMetallicRoughness"), extensions("/extensions");
  const json wrong_transform = {{"index", 0},
                                {"extensions", {{"KHR_texture_transform", {{"scale", json::array({1})}}}}}};
  const std::tuple<json::json_pointer, json, const char*> cases[] = {
      {pbr / "metallicFactor", "full", "pbrMetallicRoughness.metallicFactor"},
      {pbr / "roughnessFactor", 1e300, "pbrMetallicRoughness.roughnessFactor"},
      {pbr / "metallicRoughnessTexture", {{"index", 9}}, "metallicRoughnessTexture.index: 9 does not exist"},
      {json::json_pointer("/normalTexture"), {{"texCoord", 0}}, "normalTexture: required property index"},
      {json::json_pointer("/normalTexture"), {{"index", 0}, {"scale", nullptr}}, "normalTexture.scale"},
      {json::json_pointer("/occlusionTexture"),
       {{"index", 0}, {"strength", {}}},
       "occlusionTexture.strength"},
      {json::json_pointer("/alphaMode"), "GLASS", "alphaMode: \"GLASS\" is none of OPAQUE, MASK, BLEND"},
      {json::json_pointer("/alphaCutoff"), true, "alphaCutoff"},
      {extensions / "KHR_materials_ior", 7, "KHR_materials_ior: 7 is not an object"},
      {extensions / "KHR_materials_ior" / "ior", "x", "KHR_materials_ior.ior"},
      {extensions / "KHR_materials_emissive_strength" / "emissiveStrength", json::array({1}),
       "emissiveStrength"},
      {extensions / "KHR_materials_specular" / "specularColorFactor",
       {1, 1},
       "it has 2 numbers instead of 3"},
      {extensions / "KHR_materials_specular" / "specularTexture", {{"index", 5}}, "5 does not exist"},
      {json::json_pointer("/emissiveTexture"), wrong_transform, "KHR_texture_transform.scale"}};
  for (const auto& [place, value, message] : cases) {
    SCOPED_TRACE(place.to_string());
    json material = json::object();
    material[place] = value;
    const absl::Status status = MustFail(WithMaterial(material, 1));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(status.message(), HasSubstr("material 0: "));
    EXPECT_THAT(status.message(), HasSubstr(message));
  }
}

TEST(GltfMaterial, NumbersOutOfRangeAreMovedIntoItWithAWarning) {
  const auto scene = MustImport(WithMaterial(
      {{"name", "tin"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {2, -1, 0.5, 1}}, {"metallicFactor", 1.5}, {"roughnessFactor", -0.5}}},
       {"alphaCutoff", -3},
       {"emissiveFactor", {-1, 1e38, 4}},
       {"extensions",
        {{"KHR_materials_emissive_strength", {{"emissiveStrength", 1000}}},
         {"KHR_materials_ior", {{"ior", 0.5}}},
         {"KHR_materials_specular", {{"specularFactor", 7}, {"specularColorFactor", {-2, 3, 1}}}}}}}));
  const Material& material = scene->materials[0];
  EXPECT_EQ(material.base_color_factor, V4f(1, 0, 0.5f, 1));
  EXPECT_EQ(material.metallic_factor, 1);
  EXPECT_EQ(material.roughness_factor, 0);
  EXPECT_EQ(material.alpha_cutoff, 0);
  EXPECT_EQ(material.emissive_factor, V3f(0, std::numeric_limits<float>::max(), 4000));
  EXPECT_EQ(material.ior, 1);
  EXPECT_EQ(material.specular_factor, 1);
  EXPECT_EQ(material.specular_color_factor, V3f(0, 3, 1));
  EXPECT_EQ(scene->report.warnings.size(), 9u);
  EXPECT_THAT(scene->report.warnings, testing::Contains("material 0 (tin): metallicFactor 1.5 taken as 1"));
}

TEST(GltfMaterial, KeepsSixteenBitsOfPngs) {
  const std::vector<uint16_t> samples = {0, 1, 257, 65535, 40000, 256, 32768, 12345};
  const auto import = [&](int channels, int bits) {
    const int width = int(samples.size()) / channels;
    std::vector<uint16_t> codes = samples;
    if (bits == 8) {
      for (uint16_t& code : codes) code = uint16_t(code & 255);
    }
    return MustImport(Textured(scenes::EncodePng({width, 1, channels, bits, codes})));
  };
  EXPECT_EQ(import(4, 16)->images[0].rgba16, samples);
  EXPECT_TRUE(import(4, 16)->images[0].rgba.empty());
  EXPECT_TRUE(import(4, 8)->images[0].rgba16.empty());
  EXPECT_THAT(import(4, 8)->images[0].rgba, ElementsAre(0, 1, 1, 255, 64, 0, 0, 57));
  // Fewer channels are spread: grey to all colours, alpha to 1.
  const auto grey_and_alpha = import(2, 16);
  EXPECT_THAT(
      std::vector(grey_and_alpha->images[0].rgba16.begin(), grey_and_alpha->images[0].rgba16.begin() + 8),
      ElementsAre(0, 0, 0, 1, 257, 257, 257, 65535));
  const auto grey = import(1, 16);
  ASSERT_EQ(grey->images[0].rgba16.size(), 32u);
  for (size_t i = 0; i < 8; ++i) {
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(grey->images[0].rgba16[4 * i + c], samples[i]);
    EXPECT_EQ(grey->images[0].rgba16[4 * i + 3], 65535);
  }
  const auto rgb = MustImport(Textured(scenes::EncodePng({2, 1, 3, 16, {1, 2, 3, 4, 5, 6}})));
  EXPECT_THAT(rgb->images[0].rgba16, ElementsAre(1, 2, 3, 65535, 4, 5, 6, 65535));
}

TEST(GltfMaterial, PixelsOfSixteenBitsCountTwice) {
  const GltfBuilder file =
      Textured(scenes::EncodePng({64, 32, 4, 16, std::vector<uint16_t>(64 * 32 * 4, 7)}));
  ImportLimits limits;
  limits.max_texture_pixels = 2 * 64 * 32 - 1;
  EXPECT_EQ(MustFail(file, limits).code(), absl::StatusCode::kResourceExhausted);
  limits.max_texture_pixels = 2 * 64 * 32;
  EXPECT_TRUE(ImportBytes(file.Glb(), limits).ok());
}

}  // namespace
}  // namespace shutterline::engine::material_test
