#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <string>
#include <utility>
#include <vector>

namespace shutterline {

/// How SetUpLog's logger, which must be set up before, writes lines: "text", as SetUpLog says, or "json", one
/// object a line:
///
///     {"time":"2026-03-01T12:00:00.123Z","level":"info","program":"server","message":"job
///     accepted","job":"6f0…"}
///
/// with the fields of the message as texts. INVALID_ARGUMENT for another word. `fields` are added to every
/// line: what is true of the whole process. Before other threads log.
absl::Status SetLogFormat(absl::string_view format,
                          const std::vector<std::pair<std::string, std::string>>& fields = {});

/// A message taken apart.
struct LogLine {
  std::string message;  ///< Up to the first field.
  std::vector<std::pair<std::string, std::string>> fields;
};
/// Takes "what happened key=value key="a value"" apart, values as LogValue writes them. What has another form
/// stays in the message.
LogLine ParseLogLine(absl::string_view text);

}  // namespace shutterline
