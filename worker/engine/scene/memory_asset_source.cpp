#include "worker/engine/scene/memory_asset_source.h"

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "worker/engine/scene/gltf_uri.h"

namespace shutterline::engine {

MemoryAssetSource::MemoryAssetSource(std::string root_name, std::map<std::string, std::string> files)
    : root_name_(std::move(root_name)), files_(std::move(files)) {}

absl::StatusOr<std::string> MemoryAssetSource::Read(absl::string_view relative_uri,
                                                    uint64_t max_bytes) const {
  SL_ASSIGN_OR_RETURN(const std::string name, NormalizeRelativePath(relative_uri));
  const auto found = files_.find(name);
  if (found == files_.end()) return absl::NotFoundError(absl::StrCat("file ", name, " is not there"));
  if (found->second.size() > max_bytes) {
    return absl::ResourceExhaustedError(absl::StrCat("file ", name, " has ", found->second.size(),
                                                     " bytes, more than the limit of ", max_bytes));
  }
  return found->second;
}

}  // namespace shutterline::engine
