#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>

#include "tests/support/shared_scenes.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine/scene/gltf_import.h"

// Broken files of other projects: each ends with a status that names file, element and reason.
namespace shutterline::engine::malformed_scenes_test {
namespace {

/// Words that the message must have, by the file's path below malformed/.
const std::map<std::string, std::vector<std::string>>& Expected() {
  static const auto& expected = *new std::map<std::string, std::vector<std::string>>{
      {"validator/glb/empty_file.glb", {"empty"}},
      {"validator/glb/invalid_magic.glb", {"neither GLB"}},
      {"validator/glb/chunk_too_big.glb", {"GLB", "13"}},
      {"validator/glb/truncated_chunk_data.glb", {"GLB", "48", "47"}},
      {"validator/glb/invalid_json_chunk.glb", {"JSON"}},
      {"validator/glb/misplaced_bin_chunk.glb", {}},
      {"validator/json/invalid_syntax.gltf", {"JSON"}},
      {"validator/asset/1_0_version.gltf", {"asset.version", "1.0"}},
      {"validator/buffer/wrong_bytelength.glb", {"buffer 0", "17", "16"}},
      {"validator/buffer/no_bin_chunk.glb", {"buffer 0", "BIN"}},
      {"validator/buffer/not_found.gltf", {"buffer 0", "not there"}},
      {"validator/buffer_view/invalid_length.gltf", {"bufferView", "buffer 0"}},
      {"validator/accessor/unresolved_bufferviews.gltf", {"accessor", "bufferView", "does not exist"}},
      {"validator/accessor/invalid_sparse_count_and_stride.gltf", {"buffer 0", "no uri"}},
      {"validator/accessor_data/invalid_elements_float.gltf", {}},
      {"validator/mesh/accessor_unequal_count.gltf", {"mesh 0", "primitive 0", "COLOR_0", "count"}},
      {"validator/mesh/unresolved_positions.gltf", {"mesh 0", "POSITION", "does not exist"}},
      {"validator/mesh/morph_weights_wrong_count.gltf", {"mesh 0", "weights"}},
      {"validator/mesh_data/index_buffer_oob.gltf", {"mesh 0", "primitive 0", "indices", "vertices"}},
      {"validator/node/node_loop_scene.gltf", {"node"}},
      {"validator/node/unresolved_mesh.gltf", {"node 0", "mesh", "does not exist"}},
      {"validator/scene/unresolved_node.gltf", {"scene 0", "nodes", "does not exist"}},
      {"validator/animation/sampler_output_count_invalid.gltf", {}},
      {"validator/animation/unresolved_channel_sampler.gltf", {"animation 0", "channel", "sampler"}},
      {"validator/animation_data/invalid_input_values.gltf", {}},
      {"validator/skin/ibm_invalid_count.gltf", {"skin 2", "inverseBindMatrices", "3 joints"}},
      {"validator/skin/unresolved_joint.gltf", {"skin 0", "joints", "does not exist"}},
      {"validator/image/invalid_image_data.gltf", {"nothing to draw"}},
      {"assimp/IndexOutOfRange/IndexOutOfRange.gltf", {"mesh 0", "primitive 0", "indices", "vertices"}},
      {"tinygltf/BoundsChecking/integer-out-of-bounds.gltf", {"bufferView", "byteLength", "1e+300"}},
  };
  return expected;
}

TEST(MalformedScenes, AreRefusedWithFileElementAndReason) {
  const auto folder = FindSharedScenes();
  if (!folder.has_value()) GTEST_SKIP();
  const std::filesystem::path root = *folder + "/malformed";
  size_t met = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".glb" && extension != ".gltf") continue;
    const std::string name = std::filesystem::relative(entry.path(), root).string();
    SCOPED_TRACE(name);
    auto source = DirectoryAssetSource::Open(entry.path().string());
    ASSERT_TRUE(source.ok()) << source.status();
    // None of them has anything to draw that is whole, so a success would be an empty or a wrong picture.
    const auto scene = ImportGltf(**source);
    ASSERT_FALSE(scene.ok());
    const std::string message(scene.status().message());
    EXPECT_THAT(message, testing::HasSubstr(entry.path().filename().string()));
    const auto expected = Expected().find(name);
    ASSERT_NE(expected, Expected().end()) << "a new file: say here what its message must name";
    for (const std::string& word : expected->second) EXPECT_THAT(message, testing::HasSubstr(word));
    ++met;
  }
  EXPECT_EQ(met, Expected().size());
}

}  // namespace
}  // namespace shutterline::engine::malformed_scenes_test
