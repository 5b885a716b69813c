#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <memory>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/asset_source.h"

namespace shutterline::engine {

/// The name under which a job's environment picture travels beside its scene's files, whatever it was called
/// on disk.
inline constexpr absl::string_view kEnvironmentFile = "shutterline-environment.exr";

/// Light that comes from everywhere, linear radiance over latitude and longitude as OpenEXR has it: rows from
/// +y down, the middle column towards +z, +x to the left of it. Immutable.
struct Environment {
  int width = 0, height = 0;
  std::vector<V3f> texels;
};

/// The source's environment; null where it has none. INVALID_ARGUMENT where it is no EXR, has no channels R,
/// G and B (or Y), is not twice as wide as high, or holds a number that is not finite; RESOURCE_EXHAUSTED
/// where it is larger than kMaxEnvironmentWidth. Negative radiance counts as none.
absl::StatusOr<std::shared_ptr<const Environment>> ReadEnvironment(const AssetSource& source,
                                                                   uint64_t max_file_bytes);

/// The same from the bytes of the picture.
absl::StatusOr<std::shared_ptr<const Environment>> DecodeEnvironment(absl::string_view bytes);

inline constexpr int kMaxEnvironmentWidth = 8192;

}  // namespace shutterline::engine
