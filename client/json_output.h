#pragma once

#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "client/frame_fetch.h"
#include "client/upload.h"
#include "shutterline/v1/jobs.pb.h"

/// Facts as JSON: what --json prints. Keys are stable: they are added to, never renamed or given another
/// meaning. Sizes are bytes, times UTC as "2026-01-31T12:00:00Z" and durations seconds; a value that does
/// not exist is null.
namespace shutterline::client {

using Json = nlohmann::ordered_json;

Json ToJson(const v1::Job& job);
Json ToJson(const v1::FrameStatus& frame);
Json ToJson(const v1::Worker& worker);
Json ToJson(const FetchedFrame& frame);
Json ToJson(const UploadReport& upload);

/// Writes one document and a newline: indented, or on one line where documents follow one another. Bytes
/// that are not UTF-8 (as in file names) become U+FFFD.
void Print(const Json& json, std::ostream& out, bool one_line = false);

/// "hilbert", "center" or "coarse".
std::string WordOf(v1::TileOrder order);

/// "2026-01-31T12:00:00Z"; empty where the message holds no time.
std::string TimeText(const google::protobuf::Timestamp& time);

}  // namespace shutterline::client
