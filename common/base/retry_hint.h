#pragma once

#include <absl/status/status.h>
#include <absl/time/time.h>

#include <optional>

namespace shutterline {

/// `status` with a hint that the same call may succeed after `delay`: for UNAVAILABLE and RESOURCE_EXHAUSTED
/// that pass by themselves (a full disk, a restart). Over the wire it is google.rpc.RetryInfo. OK stays OK.
absl::Status WithRetryHint(absl::Status status, absl::Duration delay);

/// The hint, if there is one.
std::optional<absl::Duration> RetryHint(const absl::Status& status);

}  // namespace shutterline
