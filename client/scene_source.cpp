#include "client/scene_source.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine/scene/environment.h"

namespace shutterline::client {
namespace {

using engine::AssetSource;
using engine::DirectoryAssetSource;

class SceneSource final : public AssetSource {
 public:
  SceneSource(std::unique_ptr<DirectoryAssetSource> scene, std::unique_ptr<DirectoryAssetSource> environment)
      : scene_(std::move(scene)), environment_(std::move(environment)) {}

  const std::string& RootName() const override { return scene_->RootName(); }

  absl::StatusOr<std::string> Read(absl::string_view relative_uri, uint64_t max_bytes) const override {
    if (relative_uri != engine::kEnvironmentFile) return scene_->Read(relative_uri, max_bytes);
    if (environment_ == nullptr) return absl::NotFoundError("no environment was given");
    return environment_->Read(environment_->RootName(), max_bytes);
  }

 private:
  const std::unique_ptr<DirectoryAssetSource> scene_, environment_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<AssetSource>> OpenSceneSource(const std::string& scene_path,
                                                             const std::string& environment_path) {
  auto scene = DirectoryAssetSource::Open(scene_path);
  if (!scene.ok()) return Annotate(scene.status(), absl::StrCat("load scene ", scene_path));
  std::unique_ptr<DirectoryAssetSource> environment;
  if (!environment_path.empty()) {
    auto opened = DirectoryAssetSource::Open(environment_path);
    if (!opened.ok()) return Annotate(opened.status(), absl::StrCat("load environment ", environment_path));
    environment = *std::move(opened);
  }
  return std::unique_ptr<AssetSource>(new SceneSource(*std::move(scene), std::move(environment)));
}

}  // namespace shutterline::client
