#include "client/scene_files.h"

#include <absl/strings/str_cat.h>

#include <utility>
#include <vector>

#include "common/asset/digest.h"
#include "common/base/status_macros.h"
#include "worker/engine/scene/environment.h"
#include "worker/engine/scene/gltf_import.h"

namespace shutterline::client {

absl::StatusOr<SceneFiles> SceneFiles::Read(std::unique_ptr<const engine::AssetSource> source,
                                            const Limits& limits, const std::atomic<bool>* stop) {
  SceneFiles files(std::move(source), limits);
  SceneManifest& manifest = files.manifest_;
  manifest.root_name = files.source_->RootName();
  SL_ASSIGN_OR_RETURN(std::string root, files.ReadFile(manifest.root_name, stop));
  SL_ASSIGN_OR_RETURN(const std::vector<std::string> external,
                      engine::ListExternalFiles(*files.source_, root));
  files.Add(manifest.root_name, std::move(root));
  for (const std::string& name : external) {
    if (manifest.Find(name) != nullptr) continue;
    if (name == engine::kEnvironmentFile) {
      return absl::InvalidArgumentError(absl::StrCat(
          files.Context(), ": file '", name, "': the scene's environment goes by this name (--environment)"));
    }
    SL_ASSIGN_OR_RETURN(std::string bytes, files.ReadFile(name, stop));
    files.Add(name, std::move(bytes));
  }
  SL_RETURN_IF_ERROR(files.ReadEnvironment(stop));
  return files;
}

std::string SceneFiles::Context() const {
  return absl::StrCat("load scene ", source_->RootName());
}

absl::StatusOr<std::string> SceneFiles::ReadFile(const std::string& name,
                                                 const std::atomic<bool>* stop) const {
  if (stop != nullptr && *stop) return absl::CancelledError(absl::StrCat(Context(), ": interrupted"));
  SL_RETURN_IF_ERROR(Annotate(ValidateRelativeName(name), absl::StrCat(Context(), ": file '", name, "'")));
  absl::StatusOr<std::string> bytes = source_->Read(name, limits_.max_file_bytes);
  if (!bytes.ok()) return Annotate(bytes.status(), Context());
  return bytes;
}

absl::Status SceneFiles::ReadEnvironment(const std::atomic<bool>* stop) {
  const std::string name(engine::kEnvironmentFile);
  absl::StatusOr<std::string> bytes = ReadFile(name, stop);
  if (absl::IsNotFound(bytes.status())) return absl::OkStatus();
  SL_RETURN_IF_ERROR(bytes.status());
  // What the workers would refuse is refused here.
  SL_RETURN_IF_ERROR(Annotate(engine::DecodeEnvironment(*bytes).status(), Context()));
  Add(name, *std::move(bytes));
  return absl::OkStatus();
}

void SceneFiles::Add(const std::string& name, std::string bytes) {
  manifest_.files.push_back({name, Sha256(bytes), bytes.size()});
  if (bytes.size() > room_) return;
  room_ -= bytes.size();
  kept_.emplace(name, std::move(bytes));
}

absl::StatusOr<std::string> SceneFiles::Take(const SceneFile& file) {
  if (auto kept = kept_.extract(file.name)) return std::move(kept.mapped());
  absl::StatusOr<std::string> bytes = source_->Read(file.name, file.size);
  const bool grown = absl::IsResourceExhausted(bytes.status());
  if (!bytes.ok() && !grown) return bytes.status();
  if (grown || bytes->size() != file.size || Sha256(*bytes) != file.digest) {
    return absl::AbortedError(absl::StrCat("file '", file.name, "' has changed since it was hashed"));
  }
  return bytes;
}

}  // namespace shutterline::client
