#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "client/command_line.h"
#include "client/commands.h"
#include "tests/client/temp_folder.h"

namespace shutterline::client::info_test {
namespace {

struct Outcome {
  int code = 0;
  std::string out, err;
};

Outcome RunProgram(const std::vector<std::string>& words) {
  std::ostringstream out, err;
  Console console{out, err};
  Outcome outcome;
  outcome.code = RunCommandLine(words, CommandTable(), console);
  outcome.out = out.str();
  outcome.err = err.str();
  return outcome;
}

/// One triangle, drawn by two nodes, and a camera that no node places.
constexpr char kScene[] = R"({"asset":{"version":"2.0"},
  "scene":0,"scenes":[{"nodes":[0,1]}],
  "nodes":[{"mesh":0},{"mesh":0,"translation":[2,0,0]}],
  "cameras":[{"name":"Eye","type":"orthographic","orthographic":{"xmag":1,"ymag":1,"znear":0.1,"zfar":9}}],
  "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
  "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
                "min":[0,0,0],"max":[1,1,0]}],
  "bufferViews":[{"buffer":0,"byteLength":36}],
  "buffers":[{"byteLength":36,
    "uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";

TEST(Info, TellsWhatASceneContains) {
  TempFolder folder;
  folder.Write("two.gltf", kScene);
  const Outcome outcome = RunProgram({"info", folder.File("two.gltf"), "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["stored_triangles"], 1);
  EXPECT_EQ(json["drawn_triangles"], 2);
  EXPECT_EQ(json["vertices"], 3);
  EXPECT_EQ(json["mesh_nodes"], 2);
  EXPECT_EQ(json["bounds_metres"]["max"], (std::vector<double>{3, 1, 0}));
  EXPECT_EQ(json["cameras"].size(), 1u);
  EXPECT_EQ(json["cameras"][0]["name"], "Eye");
  EXPECT_EQ(json["cameras"][0]["projection"], "orthographic");
  EXPECT_TRUE(json["cameras"][0]["node"].is_null());
  EXPECT_EQ(json["animations"], nlohmann::json::array());
  EXPECT_EQ(json["lights"], nlohmann::json::array());
  EXPECT_EQ(json["materials_with"], nlohmann::json::object());

  const Outcome text = RunProgram({"info", folder.File("two.gltf")});
  EXPECT_EQ(text.code, 0);
  EXPECT_NE(text.out.find("1 stored, 2 drawn"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("\"Eye\", orthographic, not in the default scene"), std::string::npos) << text.out;
}

TEST(Info, NamesFileAndReasonOfWhatItRefuses) {
  TempFolder folder;
  folder.Write("broken.gltf", "{\"asset\":");
  for (const char* name : {"broken.gltf", "missing.gltf"}) {
    const Outcome outcome = RunProgram({"info", folder.File(name)});
    EXPECT_EQ(outcome.code, 1) << name;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err.rfind("shutterline: ", 0), 0u) << outcome.err;
    EXPECT_NE(outcome.err.find(name), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace shutterline::client::info_test
