#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <string>

namespace shutterline {

/// Sets up spdlog's default logger for a program: lines on standard error as
///
///     2026-03-01T12:00:00.123Z info  server: job accepted job=6f0… frames=24
///
/// A message says what happened and goes on in key=value fields; values that strangers chose go through
/// `LogValue`. `level` is trace, debug, info, warn, error or off; INVALID_ARGUMENT (listing these) otherwise.
/// To be called once, before other threads log.
absl::Status SetUpLog(absl::string_view program, absl::string_view level);

/// Hears the program's log from level info up, whatever level is printed. Called line by line, from any
/// thread, one at a time, under the log's lock: must not log, and must be quick.
class LogListener {
 public:
  virtual ~LogListener() = default;
  /// `line` as it is printed, with its newline; `message` is the part after the program's name.
  virtual void OnLogLine(absl::string_view line, absl::string_view message) = 0;
};

/// From SetUpLog on; listeners that are added before hear as well, from then on. Once Remove has returned,
/// the listener is not called and not being called.
void AddLogListener(LogListener* listener);
void RemoveLogListener(LogListener* listener);

/// `value` for a key=value field: quoted and escaped where it has spaces, quotes, '=' or anything that is
/// not printable ASCII, so that a line stays a line and a field a field; cut after 1 KiB with "…".
std::string LogValue(absl::string_view value);

}  // namespace shutterline
