#include "worker/assets/blob_asset_source.h"

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>

#include <algorithm>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"

namespace shutterline::worker {
namespace {

/// A scheme as RFC 3986 spells it before the first colon; drive letters look alike.
bool HasScheme(absl::string_view path) {
  const size_t colon = path.find(':');
  if (colon == absl::string_view::npos || colon == 0 || !absl::ascii_isalpha(path[0])) return false;
  return std::all_of(path.begin(), path.begin() + std::ptrdiff_t(colon), [](unsigned char c) {
    return absl::ascii_isalnum(c) || c == '+' || c == '-' || c == '.';
  });
}

absl::Status Refused(absl::string_view path, absl::string_view reason) {
  return absl::InvalidArgumentError(
      absl::StrCat("path '", absl::CHexEscape(path.substr(0, 200)), "' ", reason));
}

}  // namespace

absl::StatusOr<std::string> NormalizeRelativePath(absl::string_view path) {
  if (path.empty()) return Refused(path, "is empty");
  if (path[0] == '/' || HasScheme(path)) return Refused(path, "is absolute");
  if (path.find('\\') != absl::string_view::npos) return Refused(path, "has a backslash");
  if (path.find('\0') != absl::string_view::npos) return Refused(path, "has a zero byte");
  std::vector<absl::string_view> parts;
  for (const absl::string_view part : absl::StrSplit(path, '/')) {
    if (part.empty() || part == ".") continue;
    if (part != "..") {
      parts.push_back(part);
    } else if (parts.empty()) {
      return Refused(path, "leaves the scene's folder");
    } else {
      parts.pop_back();
    }
  }
  if (parts.empty()) return Refused(path, "names no file");
  return absl::StrJoin(parts, "/");
}

absl::StatusOr<std::unique_ptr<BlobAssetSource>> BlobAssetSource::Make(const SceneManifest& scene,
                                                                       AssetCache& cache,
                                                                       BlobFetcher& fetcher) {
  std::unique_ptr<BlobAssetSource> source(new BlobAssetSource(scene.root_name, cache, fetcher));
  for (const SceneFile& file : scene.files) {
    absl::StatusOr<std::string> path = NormalizeRelativePath(file.name);
    if (!path.ok()) return Annotate(path.status(), "scene manifest");
    if (!source->blobs_.emplace(*path, file.digest).second) {
      return Annotate(Refused(file.name, "is listed twice"), "scene manifest");
    }
    source->pins_.push_back(cache.MakePin(file.digest));
  }
  const absl::StatusOr<std::string> root_path = NormalizeRelativePath(source->root_);
  if (!root_path.ok()) return Annotate(root_path.status(), "scene manifest: root");
  if (!source->blobs_.contains(*root_path)) {
    return Annotate(Refused(source->root_, "is the root but is not listed"), "scene manifest");
  }
  return source;
}

absl::StatusOr<std::string> BlobAssetSource::Read(absl::string_view relative_uri, uint64_t max_bytes) const {
  SL_ASSIGN_OR_RETURN(const std::string path, NormalizeRelativePath(relative_uri));
  const auto blob = blobs_.find(path);
  if (blob == blobs_.end()) {
    return absl::NotFoundError(absl::StrCat("file '", path, "' is not in the scene's manifest"));
  }
  const WorkPause pause;  // For the coordinator to send it, perhaps.
  absl::StatusOr<std::string> bytes = cache_.Get(blob->second, max_bytes, fetcher_);
  if (!bytes.ok()) return Annotate(bytes.status(), absl::StrCat("file '", path, "'"));
  return bytes;
}

}  // namespace shutterline::worker
