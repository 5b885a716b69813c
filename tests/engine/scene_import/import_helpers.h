#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>

#include "tests/support/gltf_builder.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"

namespace shutterline::engine {

inline absl::StatusOr<std::shared_ptr<const Scene>> ImportBytes(const std::string& bytes,
                                                                const ImportLimits& limits = {}) {
  return ImportGltf(MemoryAssetSource("test.glb", {{"test.glb", bytes}}), limits);
}

/// The scene of a file that must import.
inline std::shared_ptr<const Scene> MustImport(const GltfBuilder& file) {
  auto scene = ImportBytes(file.Glb());
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? *scene : std::make_shared<const Scene>();
}

/// Message and code of a file that must not.
inline absl::Status MustFail(const GltfBuilder& file, const ImportLimits& limits = {}) {
  const auto scene = ImportBytes(file.Glb(), limits);
  EXPECT_FALSE(scene.ok());
  return scene.status();
}

}  // namespace shutterline::engine
