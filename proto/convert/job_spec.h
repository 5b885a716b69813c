#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include "common/asset/digest.h"
#include "common/job/job_spec.h"
#include "common/job/render_settings.h"
#include "shutterline/v1/types.pb.h"

/// Generated messages to and from common types. ToProto cannot fail. FromProto refuses, with
/// INVALID_ARGUMENT and the name of the field ("render.pattern: ..."), what a message may hold but a type
/// may not: unknown or unspecified enums, digests of a wrong length, settings out of range. `field` is the
/// message's own name in its parent, empty for a root.
namespace shutterline::convert {

v1::Digest ToProto(const Digest& digest);
v1::RenderSettings ToProto(const RenderSettings& settings);
v1::OutputSettings ToProto(const OutputSettings& settings);
v1::SceneManifest ToProto(const SceneManifest& scene);
v1::JobSpec ToProto(const JobSpec& spec);

absl::StatusOr<Digest> FromProto(const v1::Digest& message, absl::string_view field);
absl::StatusOr<RenderSettings> FromProto(const v1::RenderSettings& message, absl::string_view field);
absl::StatusOr<OutputSettings> FromProto(const v1::OutputSettings& message, absl::string_view field);
/// Translates only; `Validate` of common/job/job_spec.h checks names and numbers of files.
absl::StatusOr<SceneManifest> FromProto(const v1::SceneManifest& message, absl::string_view field);
/// Also validates the whole specification against `limits`.
absl::StatusOr<JobSpec> FromProto(const v1::JobSpec& message, const JobLimits& limits = {});

}  // namespace shutterline::convert
