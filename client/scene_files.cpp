#include "client/scene_manifest.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <string>
#include <vector>

#include "common/asset/digest.h"
#include "common/base/status_macros.h"
#include "worker/engine/scene/environment.h"
#include "worker/engine/scene/gltf_import.h"

namespace shutterline::client {

absl::StatusOr<SceneManifest> BuildManifest(const engine::AssetSource& source, uint64_t max_file_bytes) {
  engine::ImportLimits limits;
  limits.max_file_bytes = std::min(limits.max_file_bytes, max_file_bytes);
  SL_ASSIGN_OR_RETURN(const std::vector<std::string> external, engine::ListExternalFiles(source, limits));

  SceneManifest manifest;
  manifest.root_name = source.RootName();
  std::vector<std::string> names{manifest.root_name};
  for (const std::string& name : external) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  const std::string context = absl::StrCat("load scene ", manifest.root_name);
  // What the workers would refuse is refused here.
  const auto environment = engine::ReadEnvironment(source, limits.max_file_bytes);
  if (!environment.ok()) return Annotate(environment.status(), context);
  if (*environment != nullptr) names.emplace_back(engine::kEnvironmentFile);
  for (const std::string& name : names) {
    SL_RETURN_IF_ERROR(Annotate(ValidateRelativeName(name), absl::StrCat(context, ": file '", name, "'")));
    const absl::StatusOr<std::string> bytes = source.Read(name, limits.max_file_bytes);
    if (!bytes.ok()) return Annotate(bytes.status(), context);
    manifest.files.push_back({name, Sha256(*bytes), bytes->size()});
  }
  return manifest;
}

}  // namespace shutterline::client
