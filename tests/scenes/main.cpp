#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <string>

#include "common/base/atomic_file.h"
#include "tests/scenes/glb_writer.h"
#include "tests/scenes/scene_generators.h"

namespace {

using shutterline::scenes::GenerateScene;
using shutterline::scenes::SceneInfo;

/// What an option may be, for `--list`.
void PrintScene(const SceneInfo& info) {
  std::cout << info.name << "\n    " << info.summary << "\n    --seed";
  if (info.min_triangles <= info.max_triangles) std::cout << " --triangles";
  if (info.min_tessellation <= info.max_tessellation) std::cout << " --tessellation";
  if (info.max_motion >= 0) std::cout << " --motion";
  if (info.has_textures) std::cout << " --plain";
  std::cout << "\n";
}

int Fail(const absl::Status& status) {
  std::cerr << "shutterline-scenes: " << status.message() << "\n";
  return 1;
}

}  // namespace

/// Exit codes: 0 success, 1 failed, 2 usage.
int main(int argc, char** argv) {
  CLI::App app("Generates glTF scenes for tests, benchmarks and the demonstration.", "shutterline-scenes");
  std::string name, output;
  bool list = false;
  shutterline::scenes::SceneOptions options;
  app.add_option("NAME", name, "The scene's name");
  app.add_option("-o,--output", output, "The GLB file to write");
  app.add_flag("--list", list, "List the scenes and the options that each takes");
  app.add_option("--seed", options.seed, "Other scenes of the same kind (default 1)");
  app.add_option("--triangles", options.triangles, "About how many triangles");
  app.add_option("--tessellation", options.tessellation, "Cells a side");
  app.add_option("--motion", options.motion_pixels,
                 "Pixels of motion over the default shutter (0 to 0.5 frames at 24 frames a second) in a "
                 "frame of 1024 × 768");
  bool plain = false;
  app.add_flag("--plain", plain, "Without textures, as benchmarks measure the scene");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (list) {
    for (const SceneInfo& info : shutterline::scenes::AllScenes()) PrintScene(info);
    return 0;
  }
  if (name.empty() || output.empty()) {
    std::cerr << "usage: shutterline-scenes NAME -o FILE.glb (--list names the scenes, --help the options)\n";
    return 2;
  }

  options.textured = !plain;
  const absl::StatusOr<shutterline::scenes::GlbScene> scene = GenerateScene(name, options);
  if (!scene.ok()) return Fail(scene.status());
  const std::string bytes = shutterline::scenes::EncodeGlb(*scene);
  const absl::Status written = shutterline::WriteFileAtomically(output, bytes);
  if (!written.ok()) return Fail(written);
  std::cout << output << ": " << scene->DrawnTriangles() << " triangles, " << bytes.size() << " bytes\n";
  return 0;
}
