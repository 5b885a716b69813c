#include "client/output_path.h"

#include <gtest/gtest.h>

#include <string>

namespace shutterline::client::output_path_test {
namespace {

std::string File(const char* pattern, int frame, int64_t count) {
  const auto path = OutputPath::Parse(pattern);
  EXPECT_TRUE(path.ok()) << pattern << ": " << path.status();
  return path.ok() ? path->FrameFile(frame, count) : "";
}

TEST(OutputPath, HashesBecomeThePaddedFrame) {
  EXPECT_EQ(File("out.####.exr", 7, 10), "out.0007.exr");
  EXPECT_EQ(File("out.####.exr", 7, 1), "out.0007.exr");
  EXPECT_EQ(File("a/b/#.exr", 123456, 1), "a/b/123456.exr");
  EXPECT_EQ(File("f##g.EXR", 5, 2), "f05g.EXR");
  EXPECT_EQ(File("out.####.exr", -3, 2), "out.-003.exr");
  EXPECT_EQ(File("out.####.exr", -12345, 2), "out.-12345.exr");
}

TEST(OutputPath, WithoutHashesSeveralFramesAreNumbered) {
  EXPECT_EQ(File("out.exr", 7, 1), "out.exr");
  EXPECT_EQ(File("out.exr", 7, 2), "out.0007.exr");
  EXPECT_EQ(File("dir.#/out.exr", 7, 2), "dir.#/out.0007.exr") << "a folder's name is taken as it is";
}

TEST(OutputPath, RefusesWhatNamesNoFrameFile) {
  for (const std::string& text :
       {std::string(), std::string(".exr"), std::string("dir/"), std::string("dir/.exr"),
        std::string("out.png"), std::string("out"), std::string("-o.exr"), std::string("--wait.exr"),
        std::string("a#b#.exr"), std::string("a\0b.exr", 7)}) {
    EXPECT_FALSE(OutputPath::Parse(text).ok()) << "'" << text << "'";
  }
  EXPECT_TRUE(OutputPath::Parse("./-o.exr").ok());
}

TEST(OutputPath, DefaultAndPreview) {
  EXPECT_EQ(DefaultOutput("some/dir/fox.glb"), "fox.exr");
  EXPECT_EQ(DefaultOutput("fox.v2.gltf"), "fox.v2.exr");
  EXPECT_EQ(OutputPath::PreviewOf("a/fox.0001.exr"), "a/fox.0001.png");
  for (const char* scene : {"-x.glb", "a#b#c.glb", ".glb", "x", "/"}) {
    EXPECT_TRUE(OutputPath::Parse(DefaultOutput(scene)).ok()) << scene << " -> " << DefaultOutput(scene);
  }
}

}  // namespace
}  // namespace shutterline::client::output_path_test
