#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <vector>

#include "common/job/render_settings.h"

namespace shutterline::client {

/// "depth,normal": names of AOVs in any order, each once; ascending in the result.
absl::StatusOr<std::vector<Aov>> ParseAovs(absl::string_view text);
/// "object,material", likewise.
absl::StatusOr<std::vector<Matte>> ParseMattes(absl::string_view text);

/// Ambient occlusion as "lines=16,radius=2,falloff=linear,pattern=tilted,motion=on": each key at most once,
/// what is left out is as OcclusionSettings has it; "on" alone: all of that.
absl::StatusOr<OcclusionSettings> ParseOcclusion(absl::string_view text);

}  // namespace shutterline::client
