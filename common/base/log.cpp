#include "common/base/log.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>

namespace shutterline {

absl::Status SetUpLog(absl::string_view program, absl::string_view level) {
  constexpr absl::string_view kLevels[] = {"trace", "debug", "info", "warn", "error", "off"};
  if (std::find(std::begin(kLevels), std::end(kLevels), level) == std::end(kLevels)) {
    return absl::InvalidArgumentError(absl::StrCat("log level '", absl::CHexEscape(level.substr(0, 80)),
                                                   "' is none of trace, debug, info, warn, error and off"));
  }
  auto logger = std::make_shared<spdlog::logger>(std::string(program),
                                                 std::make_shared<spdlog::sinks::stderr_sink_mt>());
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%eZ %-5l %n: %v", spdlog::pattern_time_type::utc);
  logger->set_level(spdlog::level::from_str(std::string(level)));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
  return absl::OkStatus();
}

std::string LogValue(absl::string_view value) {
  constexpr size_t kMaxBytes = 1024;
  const absl::string_view kept = value.substr(0, kMaxBytes);
  const absl::string_view tail = value.size() > kMaxBytes ? "…" : "";
  const bool plain = !kept.empty() && std::all_of(kept.begin(), kept.end(), [](unsigned char c) {
    return c > 0x20 && c < 0x7f && c != '"' && c != '=' && c != '\\';
  });
  if (plain) return absl::StrCat(kept, tail);
  return absl::StrCat("\"", absl::StrReplaceAll(absl::CHexEscape(kept), {{"\\'", "'"}}), tail, "\"");
}

}  // namespace shutterline
