#include "tests/scenes/glb_writer.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/scenes/scene_generators.h"

namespace shutterline::scenes {
namespace {

using nlohmann::json;

uint32_t WordAt(const std::string& bytes, size_t at) {
  uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  return word;
}

struct Glb {
  json root;
  std::string binary;
};

/// Reads a GLB by its specification, section 4, and checks what that says.
Glb Read(const std::string& bytes) {
  Glb glb;
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(WordAt(bytes, 4), 2u);
  EXPECT_EQ(WordAt(bytes, 8), bytes.size());
  const size_t text_size = WordAt(bytes, 12);
  EXPECT_EQ(text_size % 4, 0u);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  glb.root = json::parse(bytes.substr(20, text_size));
  const size_t binary = 20 + text_size;
  EXPECT_EQ(WordAt(bytes, binary) % 4, 0u);
  EXPECT_EQ(bytes.substr(binary + 4, 4), std::string("BIN\0", 4));
  glb.binary = bytes.substr(binary + 8);
  EXPECT_EQ(glb.binary.size(), WordAt(bytes, binary));
  EXPECT_EQ(glb.root["buffers"].size(), 1u);
  EXPECT_EQ(glb.root["buffers"][0]["byteLength"], glb.binary.size());
  return glb;
}

/// The floats of an accessor, by its view.
std::vector<float> Floats(const Glb& glb, const json& accessor, size_t width) {
  const json& view = glb.root["bufferViews"][accessor["bufferView"].get<size_t>()];
  std::vector<float> values(accessor["count"].get<size_t>() * width);
  EXPECT_EQ(view["byteLength"], values.size() * 4);
  std::memcpy(values.data(), glb.binary.data() + view["byteOffset"].get<size_t>(), values.size() * 4);
  return values;
}

class EveryScene : public testing::TestWithParam<std::string> {};

TEST_P(EveryScene, IsASoundFile) {
  const auto bytes = GenerateGlb(GetParam());
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  const Glb glb = Read(*bytes);
  size_t end = 0;
  for (const json& view : glb.root["bufferViews"]) {
    EXPECT_EQ(view["byteOffset"], end);  // Tight, so nothing overlaps.
    end = view["byteOffset"].get<size_t>() + view["byteLength"].get<size_t>();
  }
  EXPECT_EQ(end, glb.binary.size());
  EXPECT_EQ(glb.root["cameras"].size(), 1u);
}

TEST_P(EveryScene, PositionsLieInTheirBounds) {
  const Glb glb = Read(GenerateGlb(GetParam()).value());
  for (const json& mesh : glb.root["meshes"]) {
    for (const json& primitive : mesh["primitives"]) {
      const json& accessor = glb.root["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
      const std::vector<float> values = Floats(glb, accessor, 3);
      for (size_t axis = 0; axis < 3; ++axis) {
        float low = std::numeric_limits<float>::max(), high = -low;
        for (size_t i = axis; i < values.size(); i += 3) {
          low = std::min(low, values[i]);
          high = std::max(high, values[i]);
        }
        EXPECT_EQ(accessor["min"][axis].get<float>(), low);
        EXPECT_EQ(accessor["max"][axis].get<float>(), high);
      }
    }
  }
}

/// Counted in the file, node by node, it is what the scene says.
TEST_P(EveryScene, DrawsTheTrianglesThatItSays) {
  const GlbScene scene = GenerateScene(GetParam()).value();
  const Glb glb = Read(EncodeGlb(scene));
  size_t indices = 0;
  for (const json& node : glb.root["nodes"]) {
    if (!node.contains("mesh")) continue;
    for (const json& primitive : glb.root["meshes"][node["mesh"].get<size_t>()]["primitives"]) {
      indices += glb.root["accessors"][primitive["indices"].get<size_t>()]["count"].get<size_t>();
    }
  }
  EXPECT_EQ(indices, 3 * size_t(scene.DrawnTriangles()));
}

TEST_P(EveryScene, SameSeedSameBytes) {
  SceneOptions first, other;
  first.seed = 7;
  other.seed = 8;
  const std::string bytes = GenerateGlb(GetParam(), first).value();
  EXPECT_TRUE(bytes == GenerateGlb(GetParam(), first).value());
  const bool leaves_nothing_to_chance =
      GetParam() == "fan" || GetParam() == "clothball" || GetParam() == "hall";
  EXPECT_EQ(bytes == GenerateGlb(GetParam(), other).value(), leaves_nothing_to_chance);
}

TEST_P(EveryScene, KeysReachBeyondTheTenthFrame) {
  const Glb glb = Read(GenerateGlb(GetParam()).value());
  if (GetParam() == "static") {
    EXPECT_FALSE(glb.root.contains("animations"));
    return;
  }
  ASSERT_EQ(glb.root["animations"].size(), 1u);
  for (const json& sampler : glb.root["animations"][0]["samplers"]) {
    const json& times = glb.root["accessors"][sampler["input"].get<size_t>()];
    EXPECT_EQ(times["min"][0], 0);
    EXPECT_GE(times["max"][0].get<double>(), 10.5 / 24);
    const json& values = glb.root["accessors"][sampler["output"].get<size_t>()];
    EXPECT_EQ(values["count"], times["count"]);
  }
}

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const SceneInfo& info : AllScenes()) names.push_back(info.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(All, EveryScene, testing::ValuesIn(Names()),
                         [](const auto& scene) { return scene.param; });

}  // namespace
}  // namespace shutterline::scenes
