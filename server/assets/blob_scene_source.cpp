#include "server/assets/blob_scene_source.h"

#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace shutterline::server {

absl::StatusOr<std::string> BlobSceneSource::Read(absl::string_view relative_uri, uint64_t max_bytes) const {
  while (absl::StartsWith(relative_uri, "./")) relative_uri.remove_prefix(2);
  SL_RETURN_IF_ERROR(ValidateRelativeName(relative_uri));
  const SceneFile* file = manifest_.Find(relative_uri);
  if (file == nullptr) {
    return absl::NotFoundError(absl::StrCat("file '", absl::CHexEscape(relative_uri.substr(0, 200)),
                                            "' is not in the scene's manifest"));
  }
  absl::StatusOr<std::string> data = store_.ReadVerified(file->digest, max_bytes);
  return data.ok() ? std::move(data) : Annotate(data.status(), absl::StrCat("file '", file->name, "'"));
}

}  // namespace shutterline::server
