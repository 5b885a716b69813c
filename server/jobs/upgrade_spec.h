#pragma once

#include "shutterline/v1/types.pb.h"

namespace shutterline::server {

/// Brings a stored specification, which an earlier build may have written, up to date: settings that the
/// build did not know yet get the values that were the default when they came. Between peers nothing is
/// filled in, so that both mean the same picture; but a store must be readable for ever.
void UpgradeSpec(v1::JobSpec& spec);

}  // namespace shutterline::server
