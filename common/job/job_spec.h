#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/asset/digest.h"
#include "common/job/render_settings.h"
#include "common/job/tile_order.h"

namespace shutterline {

/// A file of a scene: its name relative to the root file's folder, and its content.
struct SceneFile {
  std::string name;
  Digest digest;
  uint64_t size = 0;  ///< Bytes.

  friend bool operator==(const SceneFile&, const SceneFile&) = default;
};

/// The files that a scene consists of, the root file (.gltf, .glb) among them.
struct SceneManifest {
  std::string root_name;
  std::vector<SceneFile> files;

  /// The file of this name, or null.
  const SceneFile* Find(absl::string_view name) const;
  friend bool operator==(const SceneManifest&, const SceneManifest&) = default;
};

/// first, first + step, ... <= last.
struct FrameRange {
  int first = 0, last = 0, step = 1;

  int64_t Count() const { return (int64_t{last} - first) / step + 1; }
  /// Frame number `index`, 0 <= index < Count().
  int Frame(int64_t index) const { return int(first + index * step); }
  /// Where `frame` is in the range, if it is.
  std::optional<int64_t> IndexOf(int frame) const;
  friend bool operator==(const FrameRange&, const FrameRange&) = default;
};

/// All that a job asks for.
struct JobSpec {
  std::string name;  ///< For people; may be empty.
  SceneManifest scene;
  FrameRange frames;
  RenderSettings render;
  OutputSettings output;
  TileOrder order = TileOrder::kHilbert;

  friend bool operator==(const JobSpec&, const JobSpec&) = default;
};

/// What a coordinator permits; stated in its capabilities.
struct JobLimits {
  int64_t max_frames = 100'000;
  int64_t max_tiles = 50'000'000;  ///< All frames together.
  int64_t max_manifest_files = 10'000;
  int64_t max_name_bytes = 1024;  ///< Of every name and path.
};

/// INVALID_ARGUMENT naming the field, its value and the rule, unless the whole specification can be
/// rendered as far as can be told without the scene's files.
absl::Status Validate(const JobSpec& spec, const JobLimits& limits = {});

/// OK if `name` is a relative path with '/' between parts and no empty, "." or ".." part, no backslash and
/// no control character: joined to a folder it stays inside. INVALID_ARGUMENT with the reason otherwise.
absl::Status ValidateRelativeName(absl::string_view name);

/// SHA-256 over what decides pixels: the scene's files and the render settings, in an encoding that does not
/// depend on the order of files, on the wire format or on the machine. Jobs of equal keys have, build for
/// build, equal pixels in equal frames. Settings of a method that is not used count as well.
Digest PictureKey(const SceneManifest& scene, const RenderSettings& render);

}  // namespace shutterline
