#pragma once

#include <absl/status/statusor.h>

#include <nlohmann/json_fwd.hpp>

// tinygltf is used for its typed model alone: it opens no file and decodes no picture.
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <tiny_gltf.h>

namespace shutterline::engine {

/// Reads a document that has passed `ConformToGltfSchema` into tinygltf's model, without its buffers,
/// images and lights (gltf_document.h keeps those). Elements keep their numbers.
///
/// tinygltf 2.7 must not see unchecked files: it casts 64-bit sizes to int, drops channels and targets
/// that it does not like (which renumbers the rest), walks `extras` by recursion, and indexes buffers by
/// offsets that it has not compared with their size. Behind the schema none of this can happen; the
/// counts of all arrays are compared afterwards nevertheless.
absl::StatusOr<tinygltf::Model> ReadWithTinyGltf(const nlohmann::json& conforming);

}  // namespace shutterline::engine
