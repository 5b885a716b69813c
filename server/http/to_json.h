#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "server/control/events.h"
#include "server/observe/throughput.h"
#include "server/observe/timeline.h"

/// What the HTTP API tells, as JSON. Keys are stable: they are added to, never renamed. Sizes are bytes,
/// times UTC as "2026-01-31T12:00:00Z", durations seconds; a value that does not exist is null.
namespace shutterline::server {

using Json = nlohmann::ordered_json;

Json ToJson(const JobSnapshot& job);
Json ToJson(const FrameSnapshot& frame);
Json ToJson(const WorkerSnapshot& worker);
Json ToJson(const QuarantinedTile& tile);
Json ToJson(const FarmTotals& totals);
/// Rows [tile, render seconds, index of the worker].
Json ToJson(const FrameTimeline& timeline);

/// The text; what is not UTF-8 becomes U+FFFD.
std::string Dump(const Json& json);

}  // namespace shutterline::server
