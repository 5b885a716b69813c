#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <string>
#include <vector>

namespace shutterline::engine {

/// The parts of a root file, as views into its bytes.
struct GltfContainer {
  absl::string_view json;
  absl::string_view bin;  ///< Meaningful where `has_bin`.
  bool has_bin = false;
  std::vector<std::string> warnings;
};

/// Splits a GLB file into its chunks, or takes the whole as JSON where the file does not begin with the
/// GLB magic. Checks every length against the bytes that are there. The views live as long as `bytes`.
absl::StatusOr<GltfContainer> SplitGltfContainer(absl::string_view bytes);

}  // namespace shutterline::engine
