#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include "tests/engine/scene_import/import_helpers.h"

namespace shutterline::engine {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

std::string Png(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = 0;
  EXPECT_TRUE(png_image_write_get_memory_size(image, size, 0, rgba.data(), 0, nullptr));
  std::string bytes(size, '\0');
  EXPECT_TRUE(png_image_write_to_memory(&image, bytes.data(), &size, 0, rgba.data(), 0, nullptr));
  bytes.resize(size);
  return bytes;
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
  // A picture that only shading of a later kind would read is not looked at.
  file.Add("images", {{"uri", "normal.webp"}});
  file.json["materials"][0]["normalTexture"] = {{"index", file.Add("textures", {{"source", 1}})}};
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

}  // namespace
}  // namespace shutterline::engine
